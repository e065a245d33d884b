// The state of the live table: what its user has typed, and what therefore stands on the screen. No terminal here.
#pragma once

#include <string>
#include <vector>

#include "daemon/ctl/top_tables.h"

namespace gnomon::ctl {

enum class TopKey { up, down, page_up, page_down, home, end, left, right, enter, erase, escape, character };

class TopView {
 public:
  // Returns false if the user wants to leave. `character`: of TopKey::character.
  bool press(TopKey key, char character = 0);

  // Exactly `rows` lines, none longer than `columns` bytes. `trouble`: why the tables are old; empty if they are not.
  std::vector<std::string> screen(const TopTables& tables, size_t rows, size_t columns,
                                  const std::string& trouble = {});

  const SessionOrder& order() const { return order_; }

 private:
  bool command(char character);
  void type(TopKey key, char character);
  void sort_by(int step);
  std::string footer(const TopTables& tables, size_t first, size_t last) const;

  SessionOrder order_;
  bool helping_ = false;
  bool typing_ = false;  // the filter
  size_t first_ = 0;     // of the shown sessions, how many are above the screen
  size_t page_ = 1;      // sessions on the last screen
  bool to_end_ = false;  // of the sessions, when they are next shown
};

}  // namespace gnomon::ctl

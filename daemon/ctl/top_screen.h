// The terminal of `gnomonctl top`: the only place that knows ncurses.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/top_view.h"

namespace gnomon::ctl {

// Takes over the terminal until it is destroyed.
class TopScreen {
 public:
  // nullptr if standard input or output is no terminal, or one of a kind that is not known here.
  static std::unique_ptr<TopScreen> open();
  ~TopScreen();

  size_t rows() const;
  size_t columns() const;
  void draw(const std::vector<std::string>& lines);

  struct Pressed {
    TopKey key;
    char character = 0;
  };
  // The next key; nullopt if none of those that mean something was pressed within `longest`.
  std::optional<Pressed> wait_for_key(std::chrono::milliseconds longest);

  TopScreen(const TopScreen&) = delete;
  TopScreen& operator=(const TopScreen&) = delete;

 private:
  explicit TopScreen(void* terminal) : terminal_(terminal) {}

  void* terminal_;  // ncurses' SCREEN
};

}  // namespace gnomon::ctl

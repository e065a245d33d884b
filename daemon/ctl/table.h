// Text in columns, for people.
#pragma once

#include <string>
#include <vector>

namespace gnomon::ctl {

class Table {
 public:
  // Columns whose title starts with '>' are aligned to the right.
  explicit Table(std::vector<std::string> titles);

  void add(std::vector<std::string> cells);  // as many as titles
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the titles first
  std::vector<bool> right_;
};

std::string fixed(double value, int decimals);
std::string percent(double ratio);
std::string mebibytes(double bytes);

}  // namespace gnomon::ctl

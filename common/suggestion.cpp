#include "common/suggestion.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gnomon {
namespace {

constexpr size_t kLongest = 64;  // characters of a name that is compared

// The Levenshtein distance: how many characters to insert, delete or change.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> suggestion(const std::string& written, const std::vector<std::string>& known) {
  if (known.empty() || written.size() > kLongest) return std::nullopt;
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(written, a) < edit_distance(written, b);
  });
  // Two slips in a word of four letters make another word.
  const size_t most_slips = nearest->size() < 5 ? 1 : std::max<size_t>(2, nearest->size() / 3);
  if (edit_distance(written, *nearest) > most_slips) return std::nullopt;
  return *nearest;
}

}  // namespace gnomon

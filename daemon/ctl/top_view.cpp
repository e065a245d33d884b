#include "daemon/ctl/top_view.h"

#include <algorithm>

namespace gnomon::ctl {
namespace {

constexpr size_t kLongestFilter = 64;

const std::vector<std::string> kHelp = {
    "Keys",
    "",
    "  up, down, page up, page down, home, end   scroll the sessions",
    "  left, right                               sort by the column to the left or right",
    "  r                                         turn the order round",
    "  /                                         show sessions whose id, tenant or scene contains a text;",
    "                                            enter keeps it, escape shows all again",
    "  h, ?                                      this help",
    "  q                                         leave",
    "",
    "VBPS: visibility buffers a second. QUEUE, GPU and TOTAL are means over the last second: from a camera's "
    "arrival",
    "to the start of rendering, of rendering, and from its arrival to the last slice's sending.",
};

}  // namespace

bool TopView::press(TopKey key, char character) {
  if (typing_) {
    type(key, character);
    return true;
  }
  helping_ = false;
  switch (key) {
    case TopKey::up: first_ -= std::min<size_t>(first_, 1); break;
    case TopKey::down: ++first_; break;
    case TopKey::page_up: first_ -= std::min(first_, page_); break;
    case TopKey::page_down: first_ += page_; break;
    case TopKey::home: first_ = 0; break;
    case TopKey::end: to_end_ = true; break;
    case TopKey::left: sort_by(-1); break;
    case TopKey::right: sort_by(1); break;
    case TopKey::escape: order_.filter.clear(); break;
    case TopKey::character: return command(character);
    case TopKey::enter:
    case TopKey::erase: break;
  }
  return true;
}

bool TopView::command(char character) {
  switch (character) {
    case 'q': return false;
    case 'h':
    case '?': helping_ = true; break;
    case 'r': order_.ascending = !order_.ascending; break;
    case '/':
      typing_ = true;
      order_.filter.clear();
      first_ = 0;
      break;
    default: break;
  }
  return true;
}

void TopView::type(TopKey key, char character) {
  std::string& filter = order_.filter;
  if (key == TopKey::character && filter.size() < kLongestFilter) filter += character;
  if (key == TopKey::erase && !filter.empty()) filter.pop_back();
  if (key == TopKey::escape) filter.clear();
  typing_ = key != TopKey::enter && key != TopKey::escape;
}

void TopView::sort_by(int step) {
  const int count = static_cast<int>(kSessionColumns);
  const int column = (static_cast<int>(order_.by) + step + count) % count;
  order_.by = static_cast<SessionColumn>(column);
  order_.ascending =
      column < static_cast<int>(SessionColumn::size);  // names from A on, figures from the greatest on
}

std::string TopView::footer(const TopTables& tables, size_t first, size_t last) const {
  if (typing_) return "sessions that contain: " + order_.filter + "_";
  const size_t shown = tables.sessions.size() - 1;
  std::string line = shown == 0 ? "no sessions"
                                : "sessions " + std::to_string(first + 1) + " to " + std::to_string(last) + " of " +
                                      std::to_string(shown);
  if (shown < tables.all_sessions) {
    line += " that contain '" + order_.filter + "', " + std::to_string(tables.all_sessions) + " in all";
  }
  return line + "   ? help  q leave";
}

std::vector<std::string> TopView::screen(const TopTables& tables, size_t rows, size_t columns,
                                         const std::string& trouble) {
  std::vector<std::string> lines{trouble.empty() ? tables.heading : trouble, ""};
  if (helping_) {
    lines.insert(lines.end(), kHelp.begin(), kHelp.end());
  } else {
    const size_t most_tenants = std::max<size_t>(2, rows / 3);  // their titles among them
    const size_t tenants = std::min(tables.tenants.size(), most_tenants);
    lines.insert(lines.end(), tables.tenants.begin(),
                 tables.tenants.begin() + static_cast<std::ptrdiff_t>(tenants));
    if (tenants < tables.tenants.size()) {
      lines.back() = "and " + std::to_string(tables.tenants.size() - tenants + 1) + " more tenants";
    }
    lines.insert(lines.end(), {"", tables.sessions.front()});
    const size_t all = tables.sessions.size() - 1;
    page_ = rows > lines.size() + 2 ? rows - lines.size() - 1 : 1;
    const size_t furthest = all > page_ ? all - page_ : 0;
    first_ = to_end_ ? furthest : std::min(first_, furthest);
    to_end_ = false;
    const size_t last = std::min(all, first_ + page_);
    for (size_t i = first_; i < last; ++i) lines.push_back(tables.sessions[i + 1]);
    lines.resize(rows > 0 ? rows - 1 : 0);
    lines.push_back(footer(tables, first_, last));
  }
  lines.resize(rows);
  for (std::string& line : lines) line.resize(std::min(line.size(), columns));
  return lines;
}

}  // namespace gnomon::ctl

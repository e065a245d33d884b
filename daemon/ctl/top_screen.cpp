#include "daemon/ctl/top_screen.h"

#include <curses.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>

namespace gnomon::ctl {
namespace {

constexpr int kEscape = 27;
constexpr int kDelete = 127;
constexpr int kEscapeDelay = 50;  // ms: how long after an escape more of a key's code may come

std::optional<TopScreen::Pressed> pressed(int code) {
  switch (code) {
    case KEY_UP: return TopScreen::Pressed{TopKey::up};
    case KEY_DOWN: return TopScreen::Pressed{TopKey::down};
    case KEY_PPAGE: return TopScreen::Pressed{TopKey::page_up};
    case KEY_NPAGE: return TopScreen::Pressed{TopKey::page_down};
    case KEY_HOME: return TopScreen::Pressed{TopKey::home};
    case KEY_END: return TopScreen::Pressed{TopKey::end};
    case KEY_LEFT: return TopScreen::Pressed{TopKey::left};
    case KEY_RIGHT: return TopScreen::Pressed{TopKey::right};
    case KEY_ENTER:
    case '\n':
    case '\r': return TopScreen::Pressed{TopKey::enter};
    case KEY_BACKSPACE:
    case '\b':
    case kDelete: return TopScreen::Pressed{TopKey::erase};
    case kEscape: return TopScreen::Pressed{TopKey::escape};
    default: break;
  }
  if (code < ' ' || code > '~') return std::nullopt;
  return TopScreen::Pressed{TopKey::character, static_cast<char>(code)};
}

}  // namespace

std::unique_ptr<TopScreen> TopScreen::open() {
  if (isatty(STDIN_FILENO) != 1 || isatty(STDOUT_FILENO) != 1) return nullptr;
  std::setlocale(LC_CTYPE, "");
  SCREEN* const terminal = newterm(nullptr, stdout, stdin);
  if (!terminal) return nullptr;
  cbreak();
  noecho();
  keypad(stdscr, TRUE);
  set_escdelay(kEscapeDelay);
  curs_set(0);
  return std::unique_ptr<TopScreen>(new TopScreen(terminal));
}

TopScreen::~TopScreen() {
  endwin();
  delscreen(static_cast<SCREEN*>(terminal_));
}

size_t TopScreen::rows() const { return static_cast<size_t>(getmaxy(stdscr)); }
size_t TopScreen::columns() const { return static_cast<size_t>(getmaxx(stdscr)); }

void TopScreen::draw(const std::vector<std::string>& lines) {
  erase();
  for (size_t row = 0; row < lines.size(); ++row) mvaddstr(static_cast<int>(row), 0, lines[row].c_str());
  refresh();
}

std::optional<TopScreen::Pressed> TopScreen::wait_for_key(std::chrono::milliseconds longest) {
  timeout(static_cast<int>(longest.count()));
  return pressed(getch());
}

}  // namespace gnomon::ctl

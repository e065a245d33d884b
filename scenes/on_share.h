// How far a long work is, told while it is done.
#pragma once

#include <functional>

namespace gnomon::scenes {

// Of the work's time, 0 to 1 and never less than before; an estimate. Called by any thread, one call at a time. May be
// empty where nobody asks.
using OnShare = std::function<void(double share)>;

// Tells of a part of a work that goes from `begin` to `end`, as shares of the whole.
inline OnShare part_of(const OnShare& whole, double begin, double end) {
  if (!whole) return {};
  return [whole, begin, end](double share) { whole(begin + share * (end - begin)); };
}

}  // namespace gnomon::scenes

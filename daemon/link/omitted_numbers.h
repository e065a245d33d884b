// Which sequence numbers a sender leaves out. Pure.
//
// A client that reports arrivals by guess, to be sent more than its path takes (the optimistic ACK attack: RFC 9000,
// 21.4), cannot tell a number that was left out from a datagram that was lost, and reports it too.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

namespace gnomon::daemon {

class OmittedNumbers {
 public:
  // One number is left out of at most as many, one of half as many on average: the invention of a few hundred arrivals
  // is found out, and Feedbacks grow by less than a hundredth.
  static constexpr uint64_t kLongestRun = 256;

  // `random`: unpredictable numbers, of which the upper bits are used as well as the lower ones.
  explicit OmittedNumbers(std::function<uint64_t()> random) : random_(std::move(random)) {}

  // Asked before each datagram: true if the next number is to be left out, and the one after it to be used.
  bool omit_next() {
    if (left_ == 0) left_ = 1 + random_() % kLongestRun;
    return --left_ == 0;
  }

 private:
  std::function<uint64_t()> random_;
  uint64_t left_ = 0;  // datagrams before the next one that is left out
};

}  // namespace gnomon::daemon

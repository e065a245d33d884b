// A JSON value that is destroyed without an allocation.
#pragma once

#include <nlohmann/json.hpp>
#include <utility>

namespace gnomon::daemon {

// The destructor of a json makes room for all that is below it, and what is thrown there ends the daemon. This one takes
// the value apart from below, so that nothing is below what is destroyed. Recursive: for values that we make.
class TakenApart {
 public:
  explicit TakenApart(nlohmann::json value) : value_(std::move(value)) {}
  ~TakenApart() { take_apart(value_); }
  TakenApart(const TakenApart&) = delete;
  TakenApart& operator=(const TakenApart&) = delete;

  const nlohmann::json& value() const { return value_; }

 private:
  static void take_apart(nlohmann::json& value) {
    if (!value.is_structured()) return;
    for (nlohmann::json& child : value) take_apart(child);
    value.clear();
  }

  nlohmann::json value_;
};

}  // namespace gnomon::daemon

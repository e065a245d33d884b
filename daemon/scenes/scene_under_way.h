// A scene that was asked for and is not resident yet, as operators see it.
#pragma once

#include <optional>
#include <string>

#include "common/clock.h"

namespace gnomon::daemon {

struct SceneUnderWay {
  enum class Stage { queued, reading, preparing };  // waits for a reader; is read; is brought to the devices

  std::string name;
  Stage stage = Stage::queued;
  TimePoint since{};  // when it was first asked for
  // Of its reading, 0 to 1 and never less than before; in that stage alone.
  std::optional<double> share = std::nullopt;
};

inline const char* to_string(SceneUnderWay::Stage stage) {
  switch (stage) {
    case SceneUnderWay::Stage::queued: return "queued";
    case SceneUnderWay::Stage::reading: return "reading";
    case SceneUnderWay::Stage::preparing: return "preparing";
  }
  return "";
}

}  // namespace gnomon::daemon

// Asks several devices one question and joins their answers into one.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "common/result.h"
#include "daemon/render/render_inbox.h"

namespace gnomon::daemon {

enum class AnswerAt {
  first_success,  // at the first success, or when all have failed
  last            // when all have answered: an error if one of them failed
};

// Pushes `question(reply)` into each inbox; each device calls `reply` once, on any thread. `answer` is called once, on
// the thread of the deciding reply: with the error of a device, if there is one that decides, else with a success. A
// closed inbox is of a device that is gone, and counts where there is no other. Precondition: there is at least one inbox.
template <class Answer, class Question>
void ask_all(const std::vector<RenderInbox*>& inboxes, AnswerAt at, std::function<void(Result<Answer>)> answer,
             const Question& question) {
  struct Joined {
    std::mutex mutex;
    size_t left;
    bool answered = false;
    bool refused = false;  // by a device that is there
    Result<Answer> best = Error{"no device answers"};
    std::function<void(Result<Answer>)> answer;
  };
  const auto joined = std::make_shared<Joined>();
  joined->left = inboxes.size();
  joined->answer = std::move(answer);
  const auto take = [joined, at](Result<Answer> one, bool is_there) {
    std::unique_lock lock(joined->mutex);
    const bool fails = at == AnswerAt::last && is_there && !one;
    if (fails || (!joined->refused && (one || !joined->best))) joined->best = std::move(one);
    joined->refused |= fails;
    const bool decided = --joined->left == 0 || (at == AnswerAt::first_success && joined->best);
    if (!decided || std::exchange(joined->answered, true)) return;
    const Result<Answer> best = joined->best;
    lock.unlock();
    joined->answer(best);
  };
  const std::function<void(Result<Answer>)> reply = [take](Result<Answer> one) { take(std::move(one), true); };
  for (RenderInbox* inbox : inboxes) {
    if (!inbox->push(question(reply))) take(Error{"the device is gone"}, false);
  }
}

}  // namespace gnomon::daemon

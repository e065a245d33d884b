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
  last            // when all have answered
};

// Pushes `question(reply)` into each inbox; each device calls `reply` once, on any thread. `answer` is called once, on
// the thread of the deciding reply: with a success if there is one by then, else with the newest error. A closed inbox
// counts as an error. Precondition: there is at least one inbox.
template <class Answer, class Question>
void ask_all(const std::vector<RenderInbox*>& inboxes, AnswerAt at, std::function<void(Result<Answer>)> answer,
             const Question& question) {
  struct Joined {
    std::mutex mutex;
    size_t left;
    bool answered = false;
    Result<Answer> best = Error{"no device answers"};
    std::function<void(Result<Answer>)> answer;
  };
  const auto joined = std::make_shared<Joined>();
  joined->left = inboxes.size();
  joined->answer = std::move(answer);
  const std::function<void(Result<Answer>)> reply = [joined, at](Result<Answer> one) {
    std::unique_lock lock(joined->mutex);
    if (one || !joined->best) joined->best = std::move(one);
    const bool decided = --joined->left == 0 || (at == AnswerAt::first_success && joined->best);
    if (!decided || std::exchange(joined->answered, true)) return;
    const Result<Answer> best = joined->best;
    lock.unlock();
    joined->answer(best);
  };
  for (RenderInbox* inbox : inboxes) {
    if (!inbox->push(question(reply))) reply(Error{"the device is gone"});
  }
}

}  // namespace gnomon::daemon

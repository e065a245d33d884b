// Earliest eligible virtual deadline first: who is served next so that everybody gets a share by weight.
//
// After Stoica and Abdel-Wahab, "Earliest Eligible Virtual Deadline First" (1995), with WF2Q+'s rule for when nobody
// is eligible (Bennett and Zhang, 1997) and costs that are predicted first and corrected later. PROMISE.md proves what
// follows from this file.
//
// Virtual time V advances by service / (weights of all members in play). Each member has a virtual time v of its own,
// which advances by what it is charged / its weight; its lag is weight * (V - v). It is eligible when v <= V, and the
// virtual deadline of its request is v + cost / weight. Times are nanoseconds of service for weight 1.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scheduler/indexed_heap.h"

namespace gnomon::scheduler {

class VirtualQueue {
 public:
  using Member = uint32_t;  // numbers of removed members are given anew

  Member add(double weight);
  // Precondition: not waiting. What it has had in advance is worked off before it is forgotten.
  void remove(Member member);

  // The member waits with a request of that cost; or its request has changed. One that comes back from idleness
  // starts at V: it has no credit, and what it had in advance still counts.
  void wait(Member member, double cost);
  void rest(Member member);  // it waits no more

  // Who should be served. Empty: nobody waits.
  std::optional<Member> best();

  // `cost` of service more, or less, than charged so far. What a member has back while it is idle is forfeited.
  void charge(Member member, double cost);

  void set_weight(Member member, double weight);

  double lag(Member member) const;  // 0 of an idle one
  double virtual_time() const { return now_; }
  bool waits(Member member) const { return members_[member].waiting; }

 private:
  struct State {
    double v = 0;
    double weight = 1;
    double next_weight = 1;  // from when it is eligible
    double cost = 0;         // of the request
    bool waiting = false;
    bool in_play = false;  // counted in total_weight_: waiting, or v > V (in advance)
    bool leaving = false;
  };

  void place(Member member);
  void enter(Member member);
  void leave(Member member);
  void advance(double service);
  void take_arrivals();
  void reweigh(Member member, double weight);

  std::vector<State> members_;
  std::vector<Member> unused_;
  IndexedHeap<double> eligible_;    // waiting, v <= V; by virtual deadline
  IndexedHeap<double> in_advance_;  // in play, v > V; by v
  double now_ = 0;                  // V
  double total_weight_ = 0;         // of those in play
  double ahead_ = 0;                // service that V has counted and that was given back: V waits for so much
};

}  // namespace gnomon::scheduler

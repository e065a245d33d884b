// Earliest eligible virtual deadline first (EEVDF): chooses the member to serve next so that each gets a share of the
// service in proportion to its weight.
//
// After Stoica and Abdel-Wahab, "Earliest Eligible Virtual Deadline First" (1995), with the rule of WF2Q+ for when no
// member is eligible (Bennett and Zhang, "Hierarchical Packet Fair Queueing Algorithms", 1997), and with costs that are
// predicted first and corrected later. PROMISE.md proves the bounds. The caller serialises all calls.
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
  using Member = uint32_t;  // numbers of removed members are reused

  Member add(double weight);
  // Precondition: the member has no request. Its number is reused once its service in advance is worked off.
  void remove(Member member);

  // The member waits with a request of that cost, in place of an earlier one. A member that was idle starts at V at the
  // earliest: it has no credit, and service that it has had in advance still counts.
  void request(Member member, double cost);
  // The member has no request any more. Idempotent.
  void set_idle(Member member);

  // The member to serve next; nullopt if no member waits.
  std::optional<Member> best();

  // Charges `cost` of service, or gives it back if negative. What is given back to an idle member is forfeited.
  void charge(Member member, double cost);

  // A lower weight of a member that is in advance takes effect when it is in advance no longer.
  void set_weight(Member member, double weight);

  double lag(Member member) const;  // 0 if the member is idle
  bool waits(Member member) const { return members_[member].waiting; }

 private:
  struct State {
    double v = 0;
    double weight = 1;
    double next_weight = 1;  // takes effect when the member is eligible
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
  double total_weight_ = 0;         // of the members in play
  // Service that was charged, which moved V, and then given back, since jobs cost less than was predicted: V stands still
  // until as much service has been charged again.
  double ahead_ = 0;
};

}  // namespace gnomon::scheduler

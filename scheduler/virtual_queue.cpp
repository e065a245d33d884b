#include "scheduler/virtual_queue.h"

#include <algorithm>
#include <cassert>

namespace gnomon::scheduler {

VirtualQueue::Member VirtualQueue::add(double weight) {
  Member member;
  if (unused_.empty()) {
    member = static_cast<Member>(members_.size());
    members_.emplace_back();
    unused_.reserve(members_.capacity());
    eligible_.reserve(members_.capacity());
    in_advance_.reserve(members_.capacity());
  } else {
    member = unused_.back();
    unused_.pop_back();
  }
  members_[member] = State{};
  members_[member].v = now_;
  members_[member].weight = members_[member].next_weight = weight;
  return member;
}

void VirtualQueue::remove(Member member) {
  State& m = members_[member];
  assert(!m.waiting && !m.leaving);
  m.leaving = true;
  if (!m.in_play) unused_.push_back(member);  // else when it leaves play
}

void VirtualQueue::request(Member member, double cost) {
  State& m = members_[member];
  m.cost = cost;
  m.waiting = true;
  if (!m.in_play) {
    m.v = std::max(m.v, now_);
    enter(member);
  }
  place(member);
}

void VirtualQueue::set_idle(Member member) {
  State& m = members_[member];
  if (!m.waiting) return;
  m.waiting = false;
  eligible_.erase(member);
  place(member);
}

std::optional<VirtualQueue::Member> VirtualQueue::best() {
  while (eligible_.empty()) {
    if (in_advance_.empty()) return std::nullopt;
    // No waiting member is owed service: virtual time advances to where the first member is no longer in advance.
    now_ = in_advance_.top_key();
    ahead_ = 0;
    take_arrivals();
  }
  return eligible_.top();
}

void VirtualQueue::charge(Member member, double cost) {
  State& m = members_[member];
  if (!m.in_play) {
    if (cost <= 0) return;
    m.v = std::max(m.v, now_);
    enter(member);
  }
  m.v += cost / m.weight;
  place(member);
  if (cost < 0) {
    ahead_ -= cost;
  } else {
    advance(cost);
  }
}

void VirtualQueue::set_weight(Member member, double weight) {
  State& m = members_[member];
  m.next_weight = weight;
  // A member that has had service in advance at a high weight works it off at that weight; otherwise others would wait
  // longer than promised.
  if (weight > m.weight || !m.in_play || m.v <= now_) reweigh(member, weight);
}

double VirtualQueue::lag(Member member) const {
  const State& m = members_[member];
  return m.in_play ? m.weight * (now_ - m.v) : 0;
}

// Changes the weight and keeps the lag.
void VirtualQueue::reweigh(Member member, double weight) {
  State& m = members_[member];
  if (m.in_play) {
    m.v = now_ - m.weight * (now_ - m.v) / weight;
    total_weight_ += weight - m.weight;
  }
  m.weight = weight;
  if (m.in_play) place(member);
}

// Moves a member in play to the heap that it belongs to, or out of play. Precondition: the member is in play.
void VirtualQueue::place(Member member) {
  State& m = members_[member];
  if (m.v > now_) {
    eligible_.erase(member);
    return in_advance_.set(member, m.v);
  }
  in_advance_.erase(member);
  if (m.next_weight != m.weight) return reweigh(member, m.next_weight);
  if (m.waiting) {
    eligible_.set(member, m.v + m.cost / m.weight);
  } else {
    leave(member);
  }
}

void VirtualQueue::enter(Member member) {
  members_[member].in_play = true;
  total_weight_ += members_[member].weight;
}

void VirtualQueue::leave(Member member) {
  State& m = members_[member];
  m.in_play = false;
  total_weight_ -= m.weight;
  if (m.leaving) unused_.push_back(member);
}

// Advances V by service / total weight of the members in play. A member that ceases to be in advance on the way may
// leave play at that point, which changes the total weight.
void VirtualQueue::advance(double service) {
  const double counted_before = std::min(service, ahead_);
  ahead_ -= counted_before;
  service -= counted_before;
  while (!in_advance_.empty()) {
    const double until_next = (in_advance_.top_key() - now_) * total_weight_;
    if (until_next > service) break;
    service -= std::max(0.0, until_next);
    now_ = std::max(now_, in_advance_.top_key());
    take_arrivals();
  }
  if (total_weight_ > 0) now_ += service / total_weight_;
}

void VirtualQueue::take_arrivals() {
  while (!in_advance_.empty() && in_advance_.top_key() <= now_) place(in_advance_.top());
}

}  // namespace gnomon::scheduler

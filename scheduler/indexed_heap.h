// A binary heap of numbered items, smallest key first, that knows the place of each item: any item can be moved or
// removed in O(log n). Only reserve allocates.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace gnomon::scheduler {

template <class Key>
class IndexedHeap {
 public:
  // The items are 0 to items - 1 from now on. Precondition: `items` does not decrease.
  void reserve(size_t items) {
    heap_.reserve(items);
    place_.resize(items, kAbsent);
  }

  bool empty() const { return heap_.empty(); }
  bool contains(uint32_t item) const { return place_[item] != kAbsent; }
  uint32_t top() const { return heap_.front().item; }
  const Key& top_key() const { return heap_.front().key; }

  // Inserts an item, or changes its key.
  void set(uint32_t item, const Key& key) {
    size_t at = place_[item];
    if (at == kAbsent) {
      at = heap_.size();
      heap_.push_back({key, item});
      place_[item] = at;
    }
    heap_[at].key = key;
    sink(rise(at));
  }

  // Does nothing if the item is absent.
  void erase(uint32_t item) {
    const size_t at = place_[item];
    if (at == kAbsent) return;
    const Entry last = heap_.back();
    heap_.pop_back();
    place_[item] = kAbsent;
    if (at == heap_.size()) return;
    put(at, last);
    sink(rise(at));
  }

 private:
  static constexpr size_t kAbsent = SIZE_MAX;
  struct Entry {
    Key key;
    uint32_t item;
  };

  void put(size_t at, const Entry& entry) {
    heap_[at] = entry;
    place_[entry.item] = at;
  }

  size_t rise(size_t at) {
    const Entry moving = heap_[at];
    for (; at > 0 && moving.key < heap_[(at - 1) / 2].key; at = (at - 1) / 2) put(at, heap_[(at - 1) / 2]);
    put(at, moving);
    return at;
  }

  void sink(size_t at) {
    const Entry moving = heap_[at];
    while (true) {
      size_t child = 2 * at + 1;
      if (child >= heap_.size()) break;
      if (child + 1 < heap_.size() && heap_[child + 1].key < heap_[child].key) ++child;
      if (!(heap_[child].key < moving.key)) break;
      put(at, heap_[child]);
      at = child;
    }
    put(at, moving);
  }

  std::vector<Entry> heap_;
  std::vector<size_t> place_;  // by item
};

}  // namespace gnomon::scheduler

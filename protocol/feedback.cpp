#include "protocol/feedback.h"

#include <algorithm>

#include "protocol/fields.h"

namespace gnomon::protocol {
namespace {

template <class A>
void fields(A& a, Of<A, Feedback>& m) {
  a(m.time_us, m.first, m.recovered, m.incomplete, m.count);
  a.check(m.count <= kMaxReported, "too many datagrams");
  for (size_t i = 0; i < std::min<size_t>(m.count, kMaxReported); ++i) a(m.ages[i]);
}

}  // namespace

std::optional<Feedback> decode_feedback(std::span<const uint8_t> body) {
  Reader reader(body);
  Feedback feedback;
  fields(reader, feedback);
  if (!reader.ok()) return std::nullopt;
  return feedback;
}

void append_feedback(std::vector<uint8_t>& out, const Feedback& feedback) {
  Writer writer(out);
  fields(writer, feedback);
}

}  // namespace gnomon::protocol

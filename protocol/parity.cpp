#include "protocol/parity.h"

#include <isa-l/erasure_code.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "protocol/fields.h"

namespace gnomon::protocol {
namespace {

using Shard = std::vector<uint8_t>;
constexpr size_t kTableBytes = 32;  // ISA-L's multiplication table of one coefficient

template <class A>
void fields(A& a, Of<A, ParityHeader>& m) {
  a(m.frame, m.slice_count, m.groups, m.group, m.index, m.reserved);
  a.check(m.groups > 0 && m.group < m.groups && m.group < m.slice_count, "no such group");
  if constexpr (A::kReading) {
    if (a.ok()) a.check(slices_of_group(m) <= kMaxGroupSlices && m.index < kMaxGroupParity, "too large a group");
  }
}

size_t longest(const Bodies& bodies) {
  size_t size = 0;
  for (const auto& body : bodies) size = std::max(size, body.size());
  return size;
}

Shard shard_of(std::span<const uint8_t> body, size_t size) {
  Shard shard(size);
  const auto length = static_cast<uint16_t>(body.size());
  std::memcpy(shard.data(), &length, sizeof length);
  std::copy(body.begin(), body.end(), shard.begin() + kShardLengthBytes);
  return shard;
}

std::vector<uint8_t*> pointers(std::vector<Shard>& shards) {
  std::vector<uint8_t*> all;
  for (Shard& shard : shards) all.push_back(shard.data());
  return all;
}

// out = rows x in, over GF(2^8). `rows` has one row of in.size() coefficients for each shard of `out`.
void multiply(std::vector<uint8_t>& rows, std::vector<Shard>& in, std::vector<Shard>& out) {
  const int k = static_cast<int>(in.size()), count = static_cast<int>(out.size());
  std::vector<uint8_t> tables(kTableBytes * in.size() * out.size());
  ec_init_tables(k, count, rows.data(), tables.data());
  auto from = pointers(in), to = pointers(out);
  ec_encode_data(static_cast<int>(in.front().size()), k, count, tables.data(), from.data(), to.data());
}

// Appends the coefficients of parity shard `index`: coefficient j is the inverse of (k + index) XOR j.
void append_row(std::vector<uint8_t>& rows, size_t k, size_t index) {
  for (size_t j = 0; j < k; ++j) rows.push_back(gf_inv(static_cast<uint8_t>((k + index) ^ j)));
}

std::optional<Shard> body_of(const Shard& shard) {
  uint16_t length = 0;
  std::memcpy(&length, shard.data(), sizeof length);
  if (length == 0 || length > shard.size() - kShardLengthBytes) return std::nullopt;
  return Shard(shard.begin() + kShardLengthBytes, shard.begin() + kShardLengthBytes + length);
}

}  // namespace

std::optional<FrameParity> decode_parity(std::span<const uint8_t> body) {
  Reader reader(body);
  FrameParity parity;
  fields(reader, parity.header);
  if (!reader.ok() || reader.rest().size() <= kShardLengthBytes) return std::nullopt;
  parity.shard = reader.rest();
  return parity;
}

void append_parity(std::vector<uint8_t>& out, const ParityHeader& header, std::span<const uint8_t> shard) {
  Writer writer(out);
  fields(writer, header);
  out.insert(out.end(), shard.begin(), shard.end());
}

std::vector<Shard> make_parity(const Bodies& bodies, size_t count) {
  assert(!bodies.empty() && bodies.size() <= kMaxGroupSlices && count > 0 && count <= kMaxGroupParity);
  const size_t size = kShardLengthBytes + longest(bodies);
  std::vector<Shard> in, out(count, Shard(size));
  for (const auto& body : bodies) in.push_back(shard_of(body, size));
  std::vector<uint8_t> rows;
  for (size_t index = 0; index < count; ++index) append_row(rows, bodies.size(), index);
  multiply(rows, in, out);
  return out;
}

std::vector<Shard> rebuild(const Bodies& bodies, std::span<const ParityShard> parity) {
  const size_t k = bodies.size();
  std::vector<size_t> missing;
  for (size_t i = 0; i < k; ++i) {
    if (bodies[i].empty()) missing.push_back(i);
  }
  if (missing.empty() || parity.size() < missing.size() || k > kMaxGroupSlices) return {};
  const size_t size = parity[0].bytes.size();
  if (size < kShardLengthBytes + std::max<size_t>(1, longest(bodies))) return {};

  // The shards at hand and the rows of the k x k matrix that made them of all slices: a row of the identity for a slice
  // that is here, and a parity shard's row in the place of each missing one.
  std::vector<Shard> in;
  std::vector<uint8_t> made;
  size_t next = 0;
  for (size_t i = 0; i < k; ++i) {
    if (!bodies[i].empty()) {
      in.push_back(shard_of(bodies[i], size));
      made.resize(made.size() + k);
      made[i * k + i] = 1;
      continue;
    }
    const ParityShard& shard = parity[next++];
    if (shard.bytes.size() != size || shard.index >= kMaxGroupParity) return {};
    in.emplace_back(shard.bytes.begin(), shard.bytes.end());
    append_row(made, k, shard.index);
  }
  std::vector<uint8_t> inverse(k * k);
  if (gf_invert_matrix(made.data(), inverse.data(), static_cast<int>(k)) != 0) return {};  // duplicate index

  std::vector<uint8_t> rows;
  for (const size_t i : missing) rows.insert(rows.end(), inverse.begin() + i * k, inverse.begin() + (i + 1) * k);
  std::vector<Shard> out(missing.size(), Shard(size));
  multiply(rows, in, out);
  std::vector<Shard> found;
  for (const Shard& shard : out) {
    auto body = body_of(shard);
    if (!body) return {};
    found.push_back(std::move(*body));
  }
  return found;
}

}  // namespace gnomon::protocol

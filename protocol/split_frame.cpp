#include "protocol/split_frame.h"

#include <cassert>
#include <utility>

namespace gnomon::protocol {

SplitFrame::SplitFrame(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
                       const std::optional<CameraView>& camera)
    : limit_(max_payload_bytes), reference_(std::move(reference)) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  tiles_.take(frame);
  tiles_.refer_to(reference_.get(), camera);
  units_ = context::plan_units(tiles_, limit_);
  encoded_.resize(units_.size());
}

void SplitFrame::encode(size_t unit) {
  static thread_local context::UnitEncoder encoder;
  encoded_[unit].begin(CodecId::tiles_context);
  encoder.encode(tiles_, units_[unit], limit_, encoded_[unit]);
}

Result<void> SplitFrame::join(EncodedMask& out) {
  out.begin(CodecId::tiles_context);
  for (const EncodedMask& part : encoded_) {
    const size_t first = out.bytes.size();
    out.slices.insert(out.slices.end(), part.slices.begin(), part.slices.end());
    out.bytes.insert(out.bytes.end(), part.bytes.begin(), part.bytes.end());
    for (size_t i = 1; i < part.offsets.size(); ++i) out.offsets.push_back(first + part.offsets[i]);
  }
  return out.number_slices();
}

}  // namespace gnomon::protocol

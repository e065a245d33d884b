#include "protocol/context/net.h"

namespace gnomon::protocol::context {
namespace {

#include "protocol/context/net_weights.inc"

}  // namespace

template <>
const PixelNet& net() {
  static const PixelNet made(kPixelWeights);
  return made;
}
template <>
const ReferencePixelNet& net() {
  static const ReferencePixelNet made(kReferencePixelWeights);
  return made;
}
template <>
const RunNet& net() {
  static const RunNet made(kRunWeights);
  return made;
}
template <>
const ReferenceRunNet& net() {
  static const ReferenceRunNet made(kReferenceRunWeights);
  return made;
}
template <>
const ClassNet& net() {
  static const ClassNet made(kClassWeights);
  return made;
}
template <>
const ReferenceClassNet& net() {
  static const ReferenceClassNet made(kReferenceClassWeights);
  return made;
}

}  // namespace gnomon::protocol::context

#include "protocol/context/net.h"

namespace gnomon::protocol::context {
namespace {

#include "protocol/context/net_weights.inc"

}  // namespace

const PixelNet& pixel_net() {
  static const PixelNet net(kPixelShapes, kPixelWeights);
  return net;
}
const ReferencePixelNet& reference_pixel_net() {
  static const ReferencePixelNet net(kReferencePixelShapes, kReferencePixelWeights);
  return net;
}
const ClassNet& class_net() {
  static const ClassNet net(kClassShapes, kClassWeights);
  return net;
}
const ReferenceClassNet& reference_class_net() {
  static const ReferenceClassNet net(kReferenceClassShapes, kReferenceClassWeights);
  return net;
}

}  // namespace gnomon::protocol::context

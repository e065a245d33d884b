#include "client/prediction/error_balance.h"

#include <algorithm>

namespace gnomon::client {
namespace {

// The initial and greatest variance of each weight, which limits how far an error moves it, relative to the variance of
// the errors (their standard deviation is 0.3% of the bits).
constexpr std::array<double, 4> kMostTrust{3, 4'000, 1'000, 10'000};
constexpr double kForget = 0.002;  // share of kMostTrust that each error restores
constexpr double kMostWeight = 2;

}  // namespace

ErrorCurve::ErrorCurve(const ViewSize& size) : width_(size.width) {
  for (size_t i = 0; i < kTerms; ++i) trust_[i][i] = kMostTrust[i];
}

ErrorCurve::Terms ErrorCurve::terms_of(const ImageMotion& motion) const {
  return {std::min(1.0, width_ * (motion.turn + motion.shift)), motion.unseen, motion.turn, motion.shift};
}

double ErrorCurve::expect(const ImageMotion& motion) const {
  const Terms terms = terms_of(motion);
  double sum = 0;
  for (size_t i = 0; i < kTerms; ++i) sum += weights_[i] * terms[i];
  return std::min(sum, 1.0);
}

void ErrorCurve::learn(const ImageMotion& motion, double error) {
  const Terms terms = terms_of(motion);
  Terms reach{};  // trust * terms
  double spread = 1, expected = 0;
  for (size_t i = 0; i < kTerms; ++i) {
    for (size_t j = 0; j < kTerms; ++j) reach[i] += trust_[i][j] * terms[j];
    spread += terms[i] * reach[i];
    expected += weights_[i] * terms[i];
  }
  if (terms[0] < 1e-3) return;  // a resting camera carries no information
  for (size_t i = 0; i < kTerms; ++i)
    weights_[i] = std::clamp(weights_[i] + reach[i] / spread * (error - expected), 0.0, kMostWeight);
  for (size_t i = 0; i < kTerms; ++i) {
    for (size_t j = 0; j < kTerms; ++j) trust_[i][j] -= reach[i] * reach[j] / spread;
    trust_[i][i] = std::min(kMostTrust[i], trust_[i][i] + kForget * kMostTrust[i]);
  }
}

size_t ErrorBalance::choose(const PredictionChoice& choice) {
  size_t best = choice.least;
  double least_cost = 0;
  for (size_t i = choice.least; i <= choice.most(); ++i) {
    const RequestedCamera& camera = choice.cameras[i];
    const double error = curve_.expect(
        motion_between(choice.cameras.front().camera, camera.camera, options_.size, options_.distance));
    const double cost = error + options_.cost_per_s * to_seconds(choice.now - camera.asked);
    if (i > choice.least && cost > least_cost) continue;  // ties go to the newer one
    best = i;
    least_cost = cost;
  }
  return best;
}

void ErrorBalance::observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) {
  curve_.learn(motion_between(earlier, later, options_.size, options_.distance), error);
}

}  // namespace gnomon::client

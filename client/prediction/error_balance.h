// Chooses x for every frame: of all cameras that could be shown, the one with the least sum of expected error and cost
// of its age. The dissertation names this as future work (5.3).
//
// Of the candidates, only the masks are unknown: the motion between the camera of the newest masks and each candidate
// is known, and the expected error is a function of that motion. Its four coefficients are learned from predictions
// whose masks have arrived since, by recursive least squares that gradually forgets.
#pragma once

#include <array>

#include "client/prediction/motion.h"
#include "client/prediction/prediction_policy.h"

namespace gnomon::client {

struct ErrorBalanceOptions {
  ViewSize size;
  double distance = 4;       // approximate distance of what is seen, metres
  double cost_per_s = 0.15;  // of a second of response time, in share of wrong bits: 1% is worth 67 ms
};

// The expected share of wrong bits of a prediction, 0 to 1, as a function of the motion.
class ErrorCurve {
 public:
  explicit ErrorCurve(const ViewSize& size);
  double expect(const ImageMotion& motion) const;
  void learn(const ImageMotion& motion, double error);

 private:
  static constexpr size_t kTerms = 4;
  using Terms = std::array<double, kTerms>;
  Terms terms_of(const ImageMotion& motion) const;

  double width_;
  // Shares of wrong bits: for any motion at all, as edges of shadows fall between pixels; where nothing was traced; and
  // for turning and for moving by the picture's width.
  Terms weights_{0.005, 0.35, 0.02, 0.1};
  std::array<Terms, kTerms> trust_{};  // covariance of the weights, relative to the errors' variance
};

class ErrorBalance : public PredictionPolicy {
 public:
  explicit ErrorBalance(const ErrorBalanceOptions& options) : options_(options), curve_(options.size) {}
  size_t choose(const PredictionChoice& choice) override;
  void observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) override;

  const ErrorCurve& curve() const { return curve_; }

 private:
  ErrorBalanceOptions options_;
  ErrorCurve curve_;
};

}  // namespace gnomon::client

// Chooses x every frame: of all cameras that could be shown, the one of least expected error plus what its age costs.
// The dissertation's future work (5.3).
//
// The cameras are known, only their masks are not: so the motion between the seen camera and each candidate is known
// too, and the expected error is a curve over that motion, whose four coefficients are learned from predictions whose
// masks have come since (recursive least squares; what is old is forgotten by and by).
#pragma once

#include <array>

#include "client/prediction/ahead.h"
#include "client/prediction/motion.h"

namespace gnomon::client {

struct BalanceOptions {
  ViewSize size;
  double distance = 4;       // metres to what is seen, roughly
  double cost_per_s = 0.15;  // of a second of response time, as a share of wrong bits: 1% is worth 67 ms
};

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
  // Shares of wrong bits: for any motion at all, as edges of shadows fall between pixels; where nothing was traced; for
  // turning and for moving by the picture's width.
  Terms weights_{0.005, 0.35, 0.02, 0.1};
  std::array<Terms, kTerms> trust_{};  // in the last errors, against what was learned before
};

class Balance : public Ahead {
 public:
  explicit Balance(const BalanceOptions& options) : options_(options), curve_(options.size) {}
  size_t choose(const AheadChoice& choice) override;
  void observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) override;

  const ErrorCurve& curve() const { return curve_; }

 private:
  BalanceOptions options_;
  ErrorCurve curve_;
};

}  // namespace gnomon::client

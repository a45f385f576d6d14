#include "pled_vins/backend/adaptive_fusion.hpp"

#include <cmath>

namespace pled {

double paper_point_fusion(double w_ba, double z, const FusionConfig& config) noexcept {
  if (std::isnan(z)) return w_ba;
  const double alpha = config.alpha0 * std::exp(-std::abs(z - w_ba) / config.tau);
  return (1.0 - alpha) * w_ba + alpha * z;
}

double paper_line_fusion(double w_ba, double z, double alpha_line) noexcept {
  if (std::isnan(z) || std::isnan(alpha_line)) return w_ba;
  return (1.0 - alpha_line) * w_ba + alpha_line * z;
}

}  // namespace pled

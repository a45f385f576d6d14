#include "pled_vins/frontend/patch_aligner.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "pled_vins/core/check.hpp"
#include "src/frontend/simd.hpp"

namespace pled {
namespace {

/// Below this share of its pixels a patch is not trusted.
constexpr float kMinShare = 0.45F;
/// A deformation that moves the patch's rim by less than this is not worth resampling, pixels.
constexpr double kNegligibleWarpPx = 0.04;
/// Standard deviations that make the deformation's prior: image noise and change per frame.
constexpr double kNoiseGrey = 3.0;
constexpr double kDeformationSigma = 0.05;
/// A gain outside these bounds is no longer the same surface.
constexpr float kMinGain = 0.2F;
constexpr float kMaxGain = 5.0F;

constexpr std::size_t kValue = 0, kOne = 1, kGradX = 2, kGradY = 3, kFirstDeformation = 4;

/// Unit vectors of the unknowns that each step needs: shift x, shift y, gain.
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, 3> projected_units() noexcept {
  Eigen::Matrix<double, N, 3> units = Eigen::Matrix<double, N, 3>::Zero();
  units(kGradX, 0) = 1.0;
  units(kGradY, 1) = 1.0;
  units(kValue, 2) = 1.0;
  return units;
}

[[nodiscard]] bool inside(const PatchSource& s, double x, double y) noexcept {
  return x >= s.x_min && y >= s.y_min && x <= s.x_max && y <= s.y_max;  // false for NaN
}

/// Floor without a library call; offsets beyond any patch are cut off, so that a wild deformation
/// does not overflow the integer.
[[nodiscard]] float floor_of(float offset) noexcept {
  constexpr float kFar = 1024.0F;
  return static_cast<float>(static_cast<int>(std::clamp(offset, -kFar, kFar) + kFar)) - kFar;
}

/// Smaller eigenvalue of [a b; b c].
[[nodiscard]] float smaller_eigenvalue(float a, float b, float c) noexcept {
  const float diff = 0.5F * (a - c);
  return 0.5F * (a + c) - std::sqrt(diff * diff + b * b);
}

}  // namespace

PatchAligner::PatchAligner(int radius_px) noexcept
    : radius_(radius_px),
      side_(2 * radius_px + 1),
      lanes_((side_ + 7) / 8 * 8),
      wide_lanes_((side_ + 2 + 7) / 8 * 8),
      used_(static_cast<std::size_t>(side_ * lanes_)),
      llt_(Eigen::Matrix<double, 8, 8>::Identity()) {
  PLED_CHECK(radius_px >= 1 && radius_px <= kMaxPatchRadius);
  for (int v = 0; v < side_; ++v) {
    for (int u = 0; u < side_; ++u) {
      const auto i = static_cast<std::size_t>(v * lanes_ + u);
      full_mask_[i] = 1.0F;
      offset_x_[i] = static_cast<float>(u - radius_);
      offset_y_[i] = static_cast<float>(v - radius_);
    }
  }
}

bool PatchAligner::set_template(const PatchSource& source, const Eigen::Vector2d& centre_px,
                                const Eigen::Matrix2d& A_template_target, const PatchSource& target,
                                const Eigen::Vector2d& expected_px, PatchModel model,
                                float min_texture) noexcept {
  model_ = model;
  if (!inside(source, centre_px.x(), centre_px.y())) return false;
  if (!inside(target, expected_px.x(), expected_px.y())) return false;
  if (!A_template_target.allFinite()) return false;
  sample_template(source, centre_px, A_template_target);
  mask_target(target, expected_px);
  num_pixels_ = fill_columns(model);
  if (!(num_pixels_ >= kMinShare * static_cast<float>(side_ * side_))) return false;
  return solve_projector(model, num_pixels_, min_texture);
}

void PatchAligner::sample_template(const PatchSource& source, const Eigen::Vector2d& centre_px,
                                   const Eigen::Matrix2d& A) noexcept {
  const int reach = radius_ + 1;
  const int wide = side_ + 2;
  const auto x0 = static_cast<int>(centre_px.x());  // inside, so not negative: truncation is floor
  const auto y0 = static_cast<int>(centre_px.y());
  const auto fx = static_cast<float>(centre_px.x() - x0);
  const auto fy = static_cast<float>(centre_px.y() - y0);
  const double warp_px = (A - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff() * radius_;
  const bool upright = warp_px < kNegligibleWarpPx;
  // The farthest sample, and its right or lower neighbour, from the centre pixel.
  const auto extent = [&](Eigen::Index row) {
    const double share = upright ? 1.0 : std::abs(A(row, 0)) + std::abs(A(row, 1));
    return static_cast<int>(std::ceil(share * reach)) + 2;
  };
  clipped_ = x0 - extent(0) < source.x_min || x0 + extent(0) > source.x_max ||
             y0 - extent(1) < source.y_min || y0 + extent(1) > source.y_max;
  if (upright) {
    simd::sample_grid(source.image, x0 - reach, y0 - reach, fx, fy, wide, wide_lanes_,
                      wide_.data());
    if (!clipped_) return;
    const int u0 = std::max(0, source.x_min - (x0 - reach));
    const int u1 = std::min(wide, source.x_max - (x0 - reach));  // the right neighbour must exist
    const int v0 = std::max(0, source.y_min - (y0 - reach));
    const int v1 = std::min(wide, source.y_max - (y0 - reach));
    wide_valid_.fill(0.0F);
    for (int v = v0; v < v1 && u0 < u1; ++v) {
      float* row = wide_valid_.data() + v * wide_lanes_;
      std::fill(row + u0, row + u1, 1.0F);
    }
    return;
  }
  const Eigen::Matrix2f Af = A.cast<float>();
  if (clipped_) {
    sample_clipped(source, x0, y0, fx, fy, Af);
  } else {
    const simd::Affine map{Af(0, 0), Af(0, 1), Af(1, 0), Af(1, 1)};
    simd::sample_affine(source.image, x0, y0, fx, fy, map, reach, wide_lanes_, wide_.data());
  }
}

/// Sample by sample, for patches that reach past the pixels that exist.
void PatchAligner::sample_clipped(const PatchSource& source, int x0, int y0, float fx, float fy,
                                  const Eigen::Matrix2f& A) noexcept {
  const int reach = radius_ + 1;
  wide_valid_.fill(0.0F);
  for (int v = 0; v < side_ + 2; ++v) {
    const Eigen::Index row = static_cast<Eigen::Index>(v) * wide_lanes_;
    float* out = wide_.data() + row;
    float* valid = wide_valid_.data() + row;
    const auto fv = static_cast<float>(v - reach);
    for (int u = 0; u < side_ + 2; ++u) {
      const auto fu = static_cast<float>(u - reach);
      const float x = fx + A(0, 0) * fu + A(0, 1) * fv;
      const float y = fy + A(1, 0) * fu + A(1, 1) * fv;
      const float xf = floor_of(x);
      const float yf = floor_of(y);
      out[u] = 0.0F;
      if (!(xf >= static_cast<float>(source.x_min - x0) &&
            yf >= static_cast<float>(source.y_min - y0) &&
            xf < static_cast<float>(source.x_max - x0) &&
            yf < static_cast<float>(source.y_max - y0)))
        continue;
      const std::int16_t* a =
          source.image.row(y0 + static_cast<int>(yf)) + x0 + static_cast<int>(xf);
      const std::int16_t* b = a + source.image.stride;
      const float top = static_cast<float>(a[0]) + (x - xf) * static_cast<float>(a[1] - a[0]);
      const float bottom = static_cast<float>(b[0]) + (x - xf) * static_cast<float>(b[1] - b[0]);
      out[u] = (top + (y - yf) * (bottom - top)) * (1.0F / kPyramidScale);
      valid[u] = 1.0F;
    }
  }
}

/// Leaves out what would lie outside the target: there it only has copies of its border.
void PatchAligner::mask_target(const PatchSource& target,
                               const Eigen::Vector2d& expected_px) noexcept {
  const auto lowest = [](double low, double at) { return static_cast<int>(std::ceil(low - at)); };
  const auto highest = [](double high, double at) {
    return static_cast<int>(std::floor(high - at));
  };
  const int u0 = std::max(-radius_, lowest(target.x_min, expected_px.x())) + radius_ + 1;
  const int u1 = std::min(radius_, highest(target.x_max, expected_px.x())) + radius_ + 1;
  const int v0 = std::max(-radius_, lowest(target.y_min, expected_px.y())) + radius_ + 1;
  const int v1 = std::min(radius_, highest(target.y_max, expected_px.y())) + radius_ + 1;
  if (u0 == 1 && v0 == 1 && u1 == side_ && v1 == side_) return;
  if (!clipped_) {
    clipped_ = true;
    wide_valid_.fill(0.0F);
    for (int v = 0; v < side_ + 2; ++v)
      std::fill_n(wide_valid_.data() + v * wide_lanes_, side_ + 2, 1.0F);
  }
  for (int v = 1; v <= side_; ++v) {
    float* row = wide_valid_.data() + v * wide_lanes_;
    for (int u = 1; u <= side_; ++u)
      if (u < u0 || u > u1 || v < v0 || v > v1) row[u] = 0.0F;
  }
}

/// @returns the number of pixels that take part.
float PatchAligner::fill_columns(PatchModel model) noexcept {
  const auto lanes = static_cast<std::size_t>(lanes_);
  const auto wide_lanes = static_cast<std::size_t>(wide_lanes_);
  if (clipped_) fill_mask();
  const Plane& mask = clipped_ ? clipped_mask_ : full_mask_;
  const cv::v_float32x4 half = cv::v_setall_f32(0.5F);
  cv::v_float32x4 sum = cv::v_setzero_f32();
  cv::v_float32x4 count = cv::v_setzero_f32();
  for (std::size_t v = 0; v < static_cast<std::size_t>(side_); ++v) {
    const float* here = wide_.data() + (v + 1) * wide_lanes + 1;
    for (std::size_t u = 0; u < lanes; u += 4) {
      const std::size_t i = v * lanes + u;
      const cv::v_float32x4 m = cv::v_load_aligned(mask.data() + i);
      const cv::v_float32x4 value = cv::v_load(here + u) * m;
      const cv::v_float32x4 gx = (cv::v_load(here + u + 1) - cv::v_load(here + u - 1)) * half;
      const cv::v_float32x4 gy =
          (cv::v_load(here + u + wide_lanes) - cv::v_load(here + u - wide_lanes)) * half;
      cv::v_store_aligned(columns_[kOne].data() + i, m);
      cv::v_store_aligned(columns_[kValue].data() + i, value);
      cv::v_store_aligned(columns_[kGradX].data() + i, gx * m);
      cv::v_store_aligned(columns_[kGradY].data() + i, gy * m);
      sum += value;
      count += m;
    }
  }
  const float num = simd::sum(count);
  if (!(num > 0.0F)) return 0.0F;
  const cv::v_float32x4 mean = cv::v_setall_f32(simd::sum(sum) / num);
  for (std::size_t i = 0; i < used_; i += 4) {
    float* value = columns_[kValue].data() + i;
    cv::v_store_aligned(value,
                        cv::v_load_aligned(value) - mean * cv::v_load_aligned(mask.data() + i));
  }
  if (model == PatchModel::kAffine) fill_deformation_columns();
  return num;
}

/// Offset times gradient, for the four entries of the deformation.
void PatchAligner::fill_deformation_columns() noexcept {
  for (std::size_t i = 0; i < used_; i += 4) {
    const cv::v_float32x4 u = cv::v_load_aligned(offset_x_.data() + i);
    const cv::v_float32x4 v = cv::v_load_aligned(offset_y_.data() + i);
    const cv::v_float32x4 gx = cv::v_load_aligned(columns_[kGradX].data() + i);
    const cv::v_float32x4 gy = cv::v_load_aligned(columns_[kGradY].data() + i);
    cv::v_store_aligned(columns_[kFirstDeformation].data() + i, u * gx);
    cv::v_store_aligned(columns_[kFirstDeformation + 1].data() + i, v * gx);
    cv::v_store_aligned(columns_[kFirstDeformation + 2].data() + i, u * gy);
    cv::v_store_aligned(columns_[kFirstDeformation + 3].data() + i, v * gy);
  }
}

/// A pixel takes part when it and the neighbours that make its gradient exist.
void PatchAligner::fill_mask() noexcept {
  for (int v = 0; v < side_; ++v) {
    const float* above = wide_valid_.data() + v * wide_lanes_ + 1;
    const float* here = above + wide_lanes_;
    const float* below = here + wide_lanes_;
    float* mask = clipped_mask_.data() + v * lanes_;
    for (int u = 0; u < side_; ++u)
      mask[u] = here[u] * here[u - 1] * here[u + 1] * above[u] * below[u];
  }
}

/// Target = gain T + offset + gain (grad T)^T (shift + M u): linear least squares whose matrix does
/// not depend on the target, so its solution is a dot product for each unknown.
bool PatchAligner::solve_projector(PatchModel model, float num_pixels, float min_texture) noexcept {
  Eigen::Matrix<double, 8, 8> H = Eigen::Matrix<double, 8, 8>::Identity();
  const std::size_t n = model == PatchModel::kShift ? 4 : kColumns;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j)  // only the lower triangle is read
      H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          static_cast<double>(simd::dot(columns_[i].data(), columns_[j].data(), used_));
  const auto mean = [&](Eigen::Index r, Eigen::Index c) {
    return static_cast<float>(H(r, c)) / num_pixels;
  };
  if (!(smaller_eigenvalue(mean(2, 2), mean(3, 2), mean(3, 3)) > min_texture)) return false;
  template_energy_ = static_cast<float>(H(0, 0));
  if (!(template_energy_ > num_pixels)) return false;  // contrast below one grey level

  Eigen::Matrix<double, 8, 3> rows = Eigen::Matrix<double, 8, 3>::Zero();
  if (model == PatchModel::kShift) {
    const Eigen::LLT<Eigen::Matrix4d> llt(H.topLeftCorner<4, 4>());
    if (llt.info() != Eigen::Success) return false;
    rows.topRows<4>() = llt.solve(projected_units<4>());
  } else {
    constexpr double kPrior = (kNoiseGrey / kDeformationSigma) * (kNoiseGrey / kDeformationSigma);
    for (Eigen::Index k = 4; k < 8; ++k) H(k, k) += kPrior;
    llt_.compute(H);
    if (llt_.info() != Eigen::Success) return false;
    rows = llt_.solve(projected_units<8>());
  }
  if (!rows.allFinite()) return false;
  for (std::size_t k = 0; k < projector_.size(); ++k) {
    std::array<float, kColumns> weights{};
    for (std::size_t j = 0; j < n; ++j)
      weights[j] =
          static_cast<float>(rows(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)));
    std::array<const float*, kColumns> columns{};
    for (std::size_t j = 0; j < kColumns; ++j) columns[j] = columns_[j].data();
    simd::combine(columns, weights, n, used_, projector_[k].data());
  }
  return true;
}

bool PatchAligner::sample_target(const PatchSource& target,
                                 const Eigen::Vector2d& position_px) noexcept {
  if (!inside(target, position_px.x(), position_px.y())) return false;
  const auto x0 = static_cast<int>(position_px.x());  // not negative, so truncation is floor
  const auto y0 = static_cast<int>(position_px.y());
  simd::sample_grid(target.image, x0 - radius_, y0 - radius_,
                    static_cast<float>(position_px.x() - x0),
                    static_cast<float>(position_px.y() - y0), side_, lanes_, target_.data());
  return true;
}

AlignResult PatchAligner::align(const PatchSource& target, int max_steps, double tolerance_px,
                                Eigen::Vector2d& position_px) noexcept {
  AlignResult result;
  const double longest = 0.5 * radius_;
  for (int step = 0; step < max_steps; ++step) {
    if (!sample_target(target, position_px)) return result;
    if (step == 0) result.start_similarity = correlation();
    const auto [sx, sy, gain] = simd::dot3(projector_[0].data(), projector_[1].data(),
                                           projector_[2].data(), target_.data(), used_);
    if (!(sign_ * gain > kMinGain && sign_ * gain < kMaxGain)) return result;
    // The target here shows the template moved by `shift`, so the patch lies that much before.
    Eigen::Vector2d shift(static_cast<double>(sx / gain), static_cast<double>(sy / gain));
    const double length = shift.norm();
    if (!(length < 1e3)) return result;
    if (length > longest) shift *= longest / length;
    position_px -= shift;
    if (length < tolerance_px) {
      if (!sample_target(target, position_px)) return result;
      result.ok = true;
      result.similarity = correlation();
      if (model_ == PatchModel::kAffine) read_deformation(result);
      return result;
    }
  }
  return result;
}

float PatchAligner::similarity(const PatchSource& target,
                               const Eigen::Vector2d& position_px) noexcept {
  return sample_target(target, position_px) ? correlation() : -1.0F;
}

void PatchAligner::read_deformation(AlignResult& result) const noexcept {
  Eigen::Matrix<double, 8, 1> b;
  for (std::size_t k = 0; k < kColumns; ++k)
    b(static_cast<Eigen::Index>(k)) =
        static_cast<double>(simd::dot(columns_[k].data(), target_.data(), used_));
  const Eigen::Matrix<double, 8, 1> p = llt_.solve(b);
  if (!(std::abs(p(0)) > static_cast<double>(kMinGain))) return;
  result.deformation << 1.0 + p(4) / p(0), p(5) / p(0), p(6) / p(0), 1.0 + p(7) / p(0);
}

float PatchAligner::correlation() const noexcept {
  const auto [sum, cross, square] = [&] {
    cv::v_float32x4 s = cv::v_setzero_f32();
    cv::v_float32x4 c = cv::v_setzero_f32();
    cv::v_float32x4 q = cv::v_setzero_f32();
    for (std::size_t i = 0; i < used_; i += 4) {
      const cv::v_float32x4 m = cv::v_load_aligned(columns_[kOne].data() + i);
      const cv::v_float32x4 v = cv::v_load_aligned(target_.data() + i) * m;
      s += v;
      c += cv::v_load_aligned(columns_[kValue].data() + i) * v;
      q += v * v;
    }
    return std::array<float, 3>{simd::sum(s), simd::sum(c), simd::sum(q)};
  }();
  const float energy = square - sum * sum / num_pixels_;
  if (!(energy > 0.0F)) return 0.0F;
  return sign_ * cross / std::sqrt(energy * template_energy_);
}

}  // namespace pled

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "pled_vins/core/image_view.hpp"

namespace pled {

inline constexpr int kMaxPatchRadius = 10;

/// Pixels to take a patch from. Around the rectangle of pixels that exist there must be readable
/// memory of kPatchOverread values, whatever it holds.
struct PatchSource {
  ImageView<const std::int16_t> image;             ///< grey x kPyramidScale
  int x_min = 0, y_min = 0, x_max = 0, y_max = 0;  ///< pixels that exist, bounds included
  [[nodiscard]] static PatchSource whole(ImageView<const std::int16_t> image) noexcept {
    return {image, 0, 0, image.width - 1, image.height - 1};
  }
};

/// Vector loads may read so many values past the pixels that exist.
inline constexpr int kPatchOverread = 20;

/// How a patch is to be matched.
enum class PatchModel : std::uint8_t {
  kShift,   ///< translation, gain and offset
  kAffine,  ///< and a small linear deformation, solved for and reported, not applied
};

struct AlignResult {
  bool ok = false;                 ///< converged inside the image
  float start_similarity = -1.0F;  ///< the same before the first step
  float similarity = -1.0F;        ///< zero-mean normalised cross-correlation at the end, -1 ... 1
  Eigen::Matrix2d deformation =
      Eigen::Matrix2d::Identity();  ///< kAffine: template offset = deformation * offset
};

/// Inverse-compositional Lucas-Kanade for one patch (Baker and Matthews, 2004): gradients and the
/// inverse Hessian come from the template once; each step only samples the target and takes three
/// dot products. Gain and offset are solved with the shift, so exposure does not matter.
/// Fixed memory; not for two threads at once.
class PatchAligner {
 public:
  /// @param radius_px patch is (2r+1)^2, 1 ... kMaxPatchRadius
  explicit PatchAligner(int radius_px) noexcept;

  /// Takes the template at `centre_px` of `source`. `A_template_target` (2x2) takes offsets in the
  /// target image to offsets in the template's. Pixels that do not exist in the source, or would
  /// not in `target` around `expected_px`, are left out.
  /// @returns false when too few pixels are left or their texture fixes no position: smaller
  /// eigenvalue of the mean structure tensor below `min_texture` ((grey/px)^2).
  [[nodiscard]] bool set_template(const PatchSource& source, const Eigen::Vector2d& centre_px,
                                  const Eigen::Matrix2d& A_template_target,
                                  const PatchSource& target, const Eigen::Vector2d& expected_px,
                                  PatchModel model, float min_texture) noexcept;

  /// From here on the target is expected to show the template's negative: bright where it is dark.
  void set_inverted(bool inverted) noexcept { sign_ = inverted ? -1.0F : 1.0F; }

  /// Moves `position_px` in `target` until the template fits. On failure it is where it stopped.
  /// Converged when a step is below `tolerance_px`.
  [[nodiscard]] AlignResult align(const PatchSource& target, int max_steps, double tolerance_px,
                                  Eigen::Vector2d& position_px) noexcept;

  /// Correlation of the template with the target at a place; -1 when the place is outside.
  [[nodiscard]] float similarity(const PatchSource& target,
                                 const Eigen::Vector2d& position_px) noexcept;

 private:
  static constexpr int kMaxSide = 2 * kMaxPatchRadius + 1;
  static constexpr int kMaxLanes = (kMaxSide + 7) / 8 * 8;
  static constexpr int kMaxWide = (kMaxSide + 2 + 7) / 8 * 8;  ///< with a pixel more on each side
  static constexpr std::size_t kValues = std::size_t{kMaxSide} * std::size_t{kMaxLanes};
  static constexpr std::size_t kWideValues = std::size_t{kMaxSide + 2} * std::size_t{kMaxWide};
  /// Columns of the Jacobian: value, one, gradient x and y, and the four of the deformation.
  static constexpr std::size_t kColumns = 8;
  using Plane = std::array<float, kValues>;

  void sample_template(const PatchSource& source, const Eigen::Vector2d& centre_px,
                       const Eigen::Matrix2d& A_template_target) noexcept;
  void sample_clipped(const PatchSource& source, int x0, int y0, float fx, float fy,
                      const Eigen::Matrix2f& A_template_target) noexcept;
  void mask_target(const PatchSource& target, const Eigen::Vector2d& expected_px) noexcept;
  [[nodiscard]] float fill_columns(PatchModel model) noexcept;
  void fill_deformation_columns() noexcept;
  void fill_mask() noexcept;
  [[nodiscard]] bool solve_projector(PatchModel model, float num_pixels,
                                     float min_texture) noexcept;
  [[nodiscard]] bool sample_target(const PatchSource& target,
                                   const Eigen::Vector2d& position_px) noexcept;
  void read_deformation(AlignResult& result) const noexcept;
  [[nodiscard]] float correlation() const noexcept;

  int radius_;
  int side_;
  int lanes_;       ///< values from one patch row to the next
  int wide_lanes_;  ///< the same with the border for gradients
  std::size_t used_;
  PatchModel model_ = PatchModel::kShift;
  float num_pixels_ = 0.0F;
  float template_energy_ = 0.0F;                 ///< sum of squares of the mean-free template
  float sign_ = 1.0F;                            ///< -1: the target shows the negative
  bool clipped_ = false;                         ///< some pixels do not exist: wide_valid_ counts
  Eigen::LLT<Eigen::Matrix<double, 8, 8>> llt_;  ///< kAffine: normal equations of the template

  alignas(16) std::array<float, kWideValues> wide_{};        ///< template with border
  alignas(16) std::array<float, kWideValues> wide_valid_{};  ///< 1 where it exists, else 0
  alignas(16) Plane full_mask_{};     ///< 1 on the patch, 0 on the lanes past it
  alignas(16) Plane clipped_mask_{};  ///< the same without pixels that do not exist
  alignas(16) Plane offset_x_{};      ///< from the patch's centre, pixels
  alignas(16) Plane offset_y_{};
  alignas(16) std::array<Plane, kColumns> columns_{};
  alignas(16) std::array<Plane, 3> projector_{};  ///< rows for shift x, y and gain
  alignas(16) Plane target_{};
};

}  // namespace pled

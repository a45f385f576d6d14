#pragma once

#include <cstddef>
#include <vector>

namespace pled::sim {

/// A grey picture on a rectangle, kept at every halving of its resolution, so that
/// a reading averages over what a pixel sees and never flickers.
class Texture {
 public:
  Texture() = default;
  /// A rectangle of width x height metres in square texels of `texel_m`.
  Texture(double width_m, double height_m, double texel_m);
  /// A square of `texels` x `texels` (a power of two) that repeats without end.
  [[nodiscard]] static Texture repeating(int texels, double texel_m);

  [[nodiscard]] int width() const noexcept { return levels_.front().width; }
  [[nodiscard]] int height() const noexcept { return levels_.front().height; }
  [[nodiscard]] float texel_m() const noexcept { return texel_m_; }
  /// Finest level, to paint on: reflectance in [0, 1].
  [[nodiscard]] float& at(int y, int x) noexcept {
    return texels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width()) +
                   static_cast<std::size_t>(x)];
  }
  /// Averages the painted level into all coarser ones. Once, after painting.
  void build_levels();

  /// Reflectance at (u, v) metres from the corner, averaged over about
  /// `area_m2` (> 0). Trilinear; outside the rectangle its edge continues,
  /// or the picture begins anew when it repeats.
  [[nodiscard]] float sample(float u_m, float v_m, float area_m2) const noexcept;

 private:
  struct Level {
    std::size_t first = 0;  // index of its first texel
    int width = 0;
    int height = 0;
    float per_m = 0.0F;  // texels per metre
  };
  [[nodiscard]] float bilinear(const Level& level, float u_m, float v_m) const noexcept;

  float texel_m_ = 0.0F;
  bool repeats_ = false;
  std::vector<Level> levels_;
  std::vector<float> texels_;
};

}  // namespace pled::sim

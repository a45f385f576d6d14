#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <opencv2/core/hal/intrin.hpp>

#include "pled_vins/core/image_view.hpp"
#include "pled_vins/frontend/pyramid.hpp"

/// Inner loops in OpenCV's universal intrinsics: SSE and NEON from one source. The lanes are summed
/// in a fixed order, so the result does not depend on the machine's vector width.
namespace pled::simd {

inline constexpr int kLanes = 4;

[[nodiscard]] inline float sum(const cv::v_float32x4& v) noexcept {
  alignas(16) std::array<float, kLanes> lane;
  cv::v_store_aligned(lane.data(), v);
  return (lane[0] + lane[1]) + (lane[2] + lane[3]);
}

/// The values at origin + at[i] and their right neighbours. cv::v_lut_pairs loads each pair as an
/// int, which half of the places are not aligned for.
[[nodiscard]] inline cv::v_int16x8 pairs(const std::int16_t* origin,
                                         const std::array<int, kLanes>& at) noexcept {
  const auto load = [&](std::size_t lane) {
    int two;
    std::memcpy(&two, origin + at[lane], sizeof two);
    return two;
  };
  return cv::v_reinterpret_as_s16(cv::v_int32x4(load(0), load(1), load(2), load(3)));
}

/// Scalar product of n values; n is a multiple of 8, both 16-byte aligned.
[[nodiscard]] inline float dot(const float* a, const float* b, std::size_t n) noexcept {
  cv::v_float32x4 even = cv::v_setzero_f32();
  cv::v_float32x4 odd = cv::v_setzero_f32();
  for (std::size_t i = 0; i < n; i += 8) {
    even += cv::v_load_aligned(a + i) * cv::v_load_aligned(b + i);
    odd += cv::v_load_aligned(a + i + 4) * cv::v_load_aligned(b + i + 4);
  }
  return sum(even + odd);
}

/// Three scalar products with one common factor.
[[nodiscard]] inline std::array<float, 3> dot3(const float* a, const float* b, const float* c,
                                               const float* common, std::size_t n) noexcept {
  cv::v_float32x4 sa = cv::v_setzero_f32();
  cv::v_float32x4 sb = cv::v_setzero_f32();
  cv::v_float32x4 sc = cv::v_setzero_f32();
  for (std::size_t i = 0; i < n; i += 4) {
    const cv::v_float32x4 v = cv::v_load_aligned(common + i);
    sa += cv::v_load_aligned(a + i) * v;
    sb += cv::v_load_aligned(b + i) * v;
    sc += cv::v_load_aligned(c + i) * v;
  }
  return {sum(sa), sum(sb), sum(sc)};
}

/// Bilinear weights of a sub-pixel place, in 1/2^14.
struct BilinearWeights {
  std::int16_t w00, w01, w10, w11;

  BilinearWeights(float fx, float fy) noexcept {
    constexpr float kOne = 16384.0F;
    const auto round = [](float v) { return static_cast<int>(v + 0.5F); };
    const int w11_int = round(fx * fy * kOne);
    const int w01_int = round(fx * kOne) - w11_int;
    const int w10_int = round(fy * kOne) - w11_int;
    w11 = static_cast<std::int16_t>(w11_int);
    w01 = static_cast<std::int16_t>(w01_int);
    w10 = static_cast<std::int16_t>(w10_int);
    w00 = static_cast<std::int16_t>(16384 - w01_int - w10_int - w11_int);
  }
};

/// Values of pyramid pixels are this many times grey once weighted by BilinearWeights.
inline constexpr float kGreyPerWeighted = 1.0F / (16384.0F * kPyramidScale);

/// Samples `rows` x `lanes` values (grey) of a pixel grid whose first sample lies at (x0 + fx, y0 +
/// fy). `lanes` is a multiple of 8; reads rows x0 ... x0 + lanes, y0 ... y0 + rows. `out` is
/// packed.
inline void sample_grid(ImageView<const std::int16_t> image, int x0, int y0, float fx, float fy,
                        int rows, int lanes, float* out) noexcept {
  const BilinearWeights w(fx, fy);
  const cv::v_int16x8 upper(w.w00, w.w01, w.w00, w.w01, w.w00, w.w01, w.w00, w.w01);
  const cv::v_int16x8 lower(w.w10, w.w11, w.w10, w.w11, w.w10, w.w11, w.w10, w.w11);
  const cv::v_float32x4 unit = cv::v_setall_f32(kGreyPerWeighted);
  for (int x = 0; x < lanes; x += 8) {
    const std::int16_t* in = image.row(y0) + x0 + x;
    cv::v_int16x8 lo, hi;  // neighbours along x, in pairs
    cv::v_zip(cv::v_load(in), cv::v_load(in + 1), lo, hi);
    float* to = out + x;
    for (int y = 0; y < rows; ++y) {
      in += image.stride;
      cv::v_int16x8 lo_next, hi_next;
      cv::v_zip(cv::v_load(in), cv::v_load(in + 1), lo_next, hi_next);
      const cv::v_int32x4 a = cv::v_dotprod(lo, upper) + cv::v_dotprod(lo_next, lower);
      const cv::v_int32x4 b = cv::v_dotprod(hi, upper) + cv::v_dotprod(hi_next, lower);
      cv::v_store_aligned(to, cv::v_cvt_f32(a) * unit);
      cv::v_store_aligned(to + 4, cv::v_cvt_f32(b) * unit);
      lo = lo_next;
      hi = hi_next;
      to += lanes;
    }
  }
}

/// Linear map of offsets, [xx xy; yx yy].
struct Affine {
  float xx, xy, yx, yy;
};

/// Samples (2 reach + 1)^2 values (grey) at (x0 + fx, y0 + fy) + map * offset, rows `lanes` apart.
/// All of them, and their right and lower neighbours, must exist. Values past a row are undefined.
inline void sample_affine(ImageView<const std::int16_t> image, int x0, int y0, float fx, float fy,
                          const Affine& map, int reach, int lanes, float* out) noexcept {
  const std::int16_t* origin = image.row(y0) + x0;
  const auto side = 2 * reach + 1;
  const cv::v_float32x4 ramp(0.0F, 1.0F, 2.0F, 3.0F);
  const cv::v_float32x4 stride = cv::v_setall_f32(static_cast<float>(image.stride));
  const cv::v_float32x4 one = cv::v_setall_f32(16384.0F);
  const cv::v_float32x4 unit = cv::v_setall_f32(kGreyPerWeighted);
  const cv::v_float32x4 last = cv::v_setall_f32(static_cast<float>(reach));
  for (int v = 0; v < side; ++v) {
    const auto fv = static_cast<float>(v - reach);
    const cv::v_float32x4 row_x = cv::v_setall_f32(fx + map.xy * fv);
    const cv::v_float32x4 row_y = cv::v_setall_f32(fy + map.yy * fv);
    for (int u = 0; u < side; u += kLanes) {
      // Lanes past the row repeat its last place, so that they read what exists.
      const cv::v_float32x4 fu =
          cv::v_min(ramp + cv::v_setall_f32(static_cast<float>(u - reach)), last);
      const cv::v_float32x4 x = row_x + cv::v_setall_f32(map.xx) * fu;
      const cv::v_float32x4 y = row_y + cv::v_setall_f32(map.yx) * fu;
      const cv::v_float32x4 x_floor = cv::v_cvt_f32(cv::v_floor(x));
      const cv::v_float32x4 y_floor = cv::v_cvt_f32(cv::v_floor(y));
      alignas(16) std::array<int, kLanes> at;  // exact: well below 2^24
      cv::v_store_aligned(at.data(), cv::v_round(y_floor * stride + x_floor));
      const cv::v_float32x4 wx = (x - x_floor) * one;
      const cv::v_float32x4 wy = (y - y_floor) * one;
      const cv::v_int32x4 w11 = cv::v_round(wx * (y - y_floor));
      const cv::v_int32x4 w01 = cv::v_round(wx) - w11;
      const cv::v_int32x4 w10 = cv::v_round(wy) - w11;
      const cv::v_int32x4 w00 = cv::v_setall_s32(16384) - w01 - w10 - w11;
      const auto pair = [](const cv::v_int32x4& low, const cv::v_int32x4& high) {
        return cv::v_reinterpret_as_s16((low & cv::v_setall_s32(0xffff)) | (high << 16));
      };
      const cv::v_int32x4 sum = cv::v_dotprod(pairs(origin, at), pair(w00, w01)) +
                                cv::v_dotprod(pairs(origin + image.stride, at), pair(w10, w11));
      cv::v_store(out + v * lanes + u, cv::v_cvt_f32(sum) * unit);
    }
  }
}

/// out = sum over the first `num` columns of weight x column.
template <std::size_t N>
inline void combine(const std::array<const float*, N>& columns, const std::array<float, N>& weights,
                    std::size_t num, std::size_t values, float* out) noexcept {
  for (std::size_t i = 0; i < values; i += kLanes) {
    cv::v_float32x4 sum = cv::v_setzero_f32();
    for (std::size_t j = 0; j < num; ++j)
      sum += cv::v_setall_f32(weights[j]) * cv::v_load_aligned(columns[j] + i);
    cv::v_store_aligned(out + i, sum);
  }
}

}  // namespace pled::simd

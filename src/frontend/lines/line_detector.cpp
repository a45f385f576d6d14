#include "pled_vins/frontend/lines/line_detector.hpp"

#include <algorithm>
#include <optional>

#include "pled_vins/core/check.hpp"
#include "pled_vins/frontend/lines/edge_fit.hpp"
#include "pled_vins/frontend/lines/segment_merge.hpp"

namespace pled {
namespace {

/// Shorter ones are no lines whatever the share says.
constexpr double kMinLength_px = 10.0;
/// Pieces from this share of a line's length are looked at, as they may be joined.
constexpr double kPieceShare = 1.0 / 3.0;
/// Distance of the two sides of an edge on a time surface: at 20 ms decay and 100 px/s an edge has
/// faded by 1 / e^4 here.
constexpr double kTrail_px = 8.0;
/// So far an end that left the picture is followed back, pixel by pixel.
constexpr int kPull_px = 6;

}  // namespace

LineDetector::LineDetector(const LineConfig& config, const Camera& camera, LinePicture kind,
                           const LineBuffers& buffers) noexcept
    : config_(config),
      flat_(camera),
      kind_(kind),
      buffers_(buffers),
      width_px_(camera.calibration().width_px),
      height_px_(camera.calibration().height_px),
      min_length_px_(
          std::max(kMinLength_px, config.min_length_share * std::min(width_px_, height_px_))),
      trail_px_(kTrail_px) {
  PLED_CHECK(check(config).key == nullptr);
  PLED_CHECK(width_px_ >= kMinSide_px && width_px_ <= buffers.max_width_px);
  PLED_CHECK(height_px_ >= kMinSide_px && height_px_ <= buffers.max_height_px);
}

bool LineDetector::detect(ImageView<const std::uint8_t> picture, DetectedLines& out) noexcept {
  out.clear();
  if (picture.empty() || picture.width != width_px_ || picture.height != height_px_ ||
      picture.stride < picture.width)
    return false;
  if (kind_ != LinePicture::kGrey) {
    const ImageView<std::uint8_t> filtered{buffers_.filtered.data(), width_px_, height_px_,
                                           width_px_};
    median_3x3(picture, filtered);
    picture = filtered;
  }
  if (!find_segments(picture)) return false;
  merge_collinear(segments_);
  if (kind_ != LinePicture::kGrey) keep_fronts(trail_px_, segments_);
  const ImageView<GradientPixel> gradient{buffers_.gradient.data(), width_px_, height_px_,
                                          width_px_};
  sobel(picture, gradient);
  lay_on_edges(gradient);
  // Two pieces may turn out to lie on one edge.
  merge_collinear(segments_);
  take_longest(gradient, out);
  return true;
}

bool LineDetector::find_segments(ImageView<const std::uint8_t> picture) noexcept {
  const int width = shrunk_px(width_px_);
  const ImageView<std::uint8_t> shrunk{buffers_.shrunk.data(), width, shrunk_px(height_px_), width};
  shrink(picture, buffers_.row, shrunk);
  std::size_t found = 0;
  if (!find_pieces(shrunk, kLineScale * kPieceShare * min_length_px_, pieces_, found)) return false;
  segments_.clear();
  const auto raw = [&](float x, float y) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector2d px = (Eigen::Vector2d(x, y).array() + 0.5) / kLineScale - 0.5;
    return flat_.from_raw(
        px.cwiseMax(0.0).cwiseMin(Eigen::Vector2d(width_px_ - 1, height_px_ - 1)));
  };
  for (std::size_t i = 0; i < found; ++i) {
    const std::optional<Eigen::Vector2d> from = raw(pieces_[i].x0, pieces_[i].y0);
    const std::optional<Eigen::Vector2d> to = raw(pieces_[i].x1, pieces_[i].y1);
    if (!from || !to) continue;
    Segment segment;
    segment.set(*from, *to);
    if (look_across(picture, kind_, flat_, segment)) PLED_CHECK(segments_.push_back(segment));
  }
  return true;
}

void LineDetector::lay_on_edges(ImageView<const GradientPixel> gradient) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (!(segments_[i].length_px() >= min_length_px_)) continue;
    const std::optional<FittedEdge> edge = fit_edge(gradient, flat_, segments_[i]);
    if (edge && edge->bow_px <= config_.max_bow_px) segments_[kept++] = edge->segment;
  }
  while (segments_.size() > kept) segments_.pop_back();
}

bool LineDetector::pull_inside(Segment& segment, DetectedLine& line) const noexcept {
  const Eigen::Vector2d d = segment.direction();
  std::array<Eigen::Vector2d, 2> ends{segment.start(), segment.end()};
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const Eigen::Vector2d inwards = k == 0 ? d : Eigen::Vector2d(-d);
    int steps = 0;
    std::optional<Eigen::Vector2d> raw = flat_.to_raw(ends[k]);
    for (; steps < kPull_px && !(raw && flat_.camera().inside(*raw)); ++steps) {
      ends[k] += inwards;
      raw = flat_.to_raw(ends[k]);
    }
    if (!raw || !flat_.camera().inside(*raw)) return false;
    line.raw_px[k] = {raw->x(), raw->y()};
  }
  segment.set(ends[0], ends[1]);
  return segment.length_px() >= min_length_px_;
}

void LineDetector::take_longest(ImageView<const GradientPixel> gradient,
                                DetectedLines& out) const noexcept {
  for (Segment segment : segments_) {
    if (out.size() == static_cast<std::size_t>(config_.max_lines)) return;
    DetectedLine line;
    if (!pull_inside(segment, line)) continue;
    line.segment = segment;
    line.descriptor =
        compare_bands(line_bands(gradient, Eigen::Vector2d(line.raw_px[0][0], line.raw_px[0][1]),
                                 Eigen::Vector2d(line.raw_px[1][0], line.raw_px[1][1])));
    PLED_CHECK(out.push_back(line));
  }
}

}  // namespace pled

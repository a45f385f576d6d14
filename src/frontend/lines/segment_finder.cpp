#include "pled_vins/frontend/lines/segment_finder.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <tuple>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "pled_vins/core/check.hpp"

namespace pled {
namespace {

constexpr int kRefine = 1;
/// The picture comes blurred and shrunk: LSD is to do neither, and then starts no threads.
constexpr double kScale = 1.0;
constexpr double kSigmaScale = 0.6;
constexpr double kQuantisation = 2.0;
constexpr double kAngle_deg = 22.5;
constexpr double kLogEps = 0.0;  // of refinement 2 only
constexpr double kDensity = 0.7;
constexpr int kBins = 1024;

float square_length(const cv::Vec4f& v) noexcept {
  const float dx = v[2] - v[0];
  const float dy = v[3] - v[1];
  return dx * dx + dy * dy;
}

/// A whole order, so that pieces of one length come in one order too.
bool goes_before(const cv::Vec4f& a, const cv::Vec4f& b) noexcept {
  return std::tuple(-square_length(a), a[1], a[0], a[3], a[2]) <
         std::tuple(-square_length(b), b[1], b[0], b[3], b[2]);
}

}  // namespace

bool find_pieces(ImageView<const std::uint8_t> shrunk, double min_length_px,
                 std::span<ShrunkPiece> pieces, std::size_t& found) noexcept {
  PLED_CHECK(shrunk.width >= 8 && shrunk.height >= 8);
  found = 0;
  try {
    // LSD reads only; cv::Mat has no header for constant pixels.
    const cv::Mat image(shrunk.height, shrunk.width, CV_8UC1,
                        const_cast<std::uint8_t*>(shrunk.data),
                        static_cast<std::size_t>(shrunk.stride));
    std::vector<cv::Vec4f> lines;
    cv::createLineSegmentDetector(kRefine, kScale, kSigmaScale, kQuantisation, kAngle_deg, kLogEps,
                                  kDensity, kBins)
        ->detect(image, lines);
    const auto least = static_cast<float>(min_length_px * min_length_px);
    std::erase_if(lines, [&](const cv::Vec4f& v) { return !(square_length(v) >= least); });
    std::sort(lines.begin(), lines.end(), goes_before);
    found = std::min(lines.size(), pieces.size());
    for (std::size_t i = 0; i < found; ++i)
      pieces[i] = {lines[i][0], lines[i][1], lines[i][2], lines[i][3]};
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace pled

#include "src/report/moments_part.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/decode/decimal.hpp"
#include "drivers/replay/frame_list.hpp"
#include "drivers/replay/image_reader.hpp"
#include "src/report/event_pass.hpp"
#include "src/report/event_pictures.hpp"
#include "src/report/labels.hpp"
#include "src/report/picture.hpp"

namespace pled::report {
namespace {

constexpr int kMaxPicture_px = 640;
/// Sensors are silent in a still scene; longer than this is worth a mark.
constexpr std::int64_t kEventSilence_ns = 100'000'000;
constexpr std::int64_t kNsPerUs = 1000;
constexpr int kPixelDecimals = 1;
constexpr int kWeightDecimals = 3;

const char* letter(const FeatureRow& row) {
  switch (row.kind) {
    case Kind::kEventPoint: return "e";
    case Kind::kLine: return is_of_events(row) ? "L" : "l";
    default: return "i";
  }
}

/// [kind, u0, v0, u1, v1, w, used, moving, w_temporal, w_geometric]: arrays, because
/// names for each of some thousand rows would weigh more than the values.
Json feature(const LabelledRow& r) {
  const FeatureRow& row = r.row;
  return {letter(row),
          rounded(row.begin_px[0], kPixelDecimals),
          rounded(row.begin_px[1], kPixelDecimals),
          rounded(row.end_px[0], kPixelDecimals),
          rounded(row.end_px[1], kPixelDecimals),
          rounded(row.w, kWeightDecimals),
          row.used ? 1 : 0,
          r.moving ? 1 : 0,
          rounded(row.w_temporal, kWeightDecimals),
          rounded(row.w_geometric, kWeightDecimals)};
}

Json without_pictures(const std::vector<Moment>& moments, PlayedSpan span) {
  Json out = Json::array();
  for (const Moment& moment : moments) {
    Json features = Json::array();
    for (const LabelledRow& row : moment.rows) features.push_back(feature(row));
    out.push_back({{"t_s", since_s(moment.stamp_ns, span.first_ns)}, {"features", features}});
  }
  return out;
}

/// Adds the frames of a container, which can only be gone through from the beginning.
void add_contained_frames(const std::vector<Moment>& moments, const replay::Recording& recording,
                          std::size_t bytes_each, Json& out, std::vector<std::string>& notes) {
  replay::Problems problems;
  auto source = recording.open_frames(1, problems);
  for (const replay::Problem& problem : problems) notes.push_back(replay::to_string(problem));
  std::size_t k = 0;
  while (source.ok() && k < moments.size()) {
    const auto frame = source.value()->acquire(Duration{});
    if (!frame.ok() && frame.error().code == ErrorCode::kCorrupt) continue;
    if (!frame.ok()) break;
    while (k < moments.size() && moments[k].stamp_ns < frame.value().stamp_ns) ++k;
    if (k < moments.size() && moments[k].stamp_ns == frame.value().stamp_ns) {
      out[k]["frame"] = png_base64_within(shrunk(frame.value().image, kMaxPicture_px), bytes_each);
      ++k;
    }
    source.value()->release();
  }
}

/// Adds the frames of a list: only those that are shown are decoded.
void add_listed_frames(const std::vector<Moment>& moments, const replay::Recording& recording,
                       std::size_t bytes_each, Json& out, std::vector<std::string>& notes) {
  const replay::RecordingFiles& files = recording.files();
  const auto format = recording.layout() == replay::Layout::kEuroc ? replay::FrameListFormat::kEuroc
                                                                   : replay::FrameListFormat::kRpg;
  auto list = replay::FrameList::open(files.frames, format);
  if (!list.ok()) return notes.push_back(replay::open_failure(files.frames, list.error()));
  const replay::ImageSize size = recording.frame_size();
  replay::ImageReader reader(size);
  Picture pixels(size.width_px, size.height_px);
  replay::Message ignored;
  std::size_t k = 0;
  while (k < moments.size()) {
    const auto entry = list.value().next(ignored);
    if (!entry.ok() && entry.error().code == ErrorCode::kEndOfStream) break;
    if (!entry.ok() && entry.error().code != ErrorCode::kCorrupt) break;
    if (!entry.ok()) continue;
    while (k < moments.size() && moments[k].stamp_ns < entry.value().stamp_ns) ++k;
    if (k == moments.size() || moments[k].stamp_ns != entry.value().stamp_ns) continue;
    const std::string path = files.frame_folder + "/" + std::string(entry.value().name);
    const auto read = reader.read(path.c_str(), pixels.pixels);
    if (read.ok() && read.value() == size)
      out[k]["frame"] = png_base64_within(shrunk(pixels.view(), kMaxPicture_px), bytes_each);
    else
      notes.push_back(path + ": " + std::string(reader.last_message()) + "; not shown");
    ++k;
  }
}

void add_labels(const std::vector<Moment>& moments, const replay::Recording& recording, Json& out) {
  Labels labels(&recording);
  for (std::size_t k = 0; k < moments.size(); ++k)
    if (const auto image = labels.at(moments[k].stamp_ns))
      out[k]["labels"] = png_base64(thinned(*image, kMaxPicture_px));
}

/// One pass over the events for the rates of all and the pictures of some.
void add_events(const std::vector<Moment>& moments, const replay::Recording& recording,
                PlayedSpan span, std::size_t bytes_each, Json& out, Json& rates,
                std::vector<std::string>& notes) {
  std::vector<std::int64_t> stamps_us;
  for (const Moment& moment : moments) stamps_us.push_back(rounded_to_us(moment.stamp_ns));
  EventPictures pictures(stamps_us, recording.event_size(), kMaxPicture_px);
  RateCounter counter(span, kEventSilence_ns);
  const std::string problem = visit_events(recording, [&](std::span<const Event> events) {
    pictures.add(events);
    for (const Event& event : events) counter.add(event.t.us * kNsPerUs);
    return events.empty() || events.back().t.us * kNsPerUs <= span.last_ns;
  });
  if (!problem.empty()) notes.push_back(problem);
  rates = counter.to_json();
  for (std::size_t k = 0; k < moments.size(); ++k) {
    out[k]["event_count"] = pictures.count(k);
    if (pictures.count(k) == 0) continue;
    // Two colours cannot be averaged: a picture that is too heavy loses pixels instead.
    int width = pictures.picture(k).width_px;
    std::string png = png_base64(pictures.picture(k));
    while (png.size() > bytes_each && width > 64) {
      width = width * 4 / 5;
      png = png_base64(thinned(pictures.picture(k).view(), width));
    }
    out[k]["events"] = png;
  }
}

}  // namespace

Json make_moments(const std::vector<Moment>& moments, const replay::Recording* recording,
                  PlayedSpan span, std::size_t picture_bytes, Json& event_rates,
                  std::vector<std::string>& notes) {
  Json list = without_pictures(moments, span);
  Json out;
  if (recording != nullptr) {
    const std::size_t each = picture_bytes / std::max<std::size_t>(moments.size(), 1);
    const bool has_events =
        recording->has(replay::Stream::kEvents) && recording->event_size().width_px > 0;
    if (recording->has(replay::Stream::kFrames)) {
      const auto add_frames =
          recording->container() != nullptr ? add_contained_frames : add_listed_frames;
      add_frames(moments, *recording, has_events ? each * 2 / 3 : each, list, notes);
    }
    if (recording->has(replay::Stream::kMasks)) add_labels(moments, *recording, list);
    if (has_events) add_events(moments, *recording, span, each / 3, list, event_rates, notes);
    out["width_px"] = recording->frame_size().width_px;
    out["height_px"] = recording->frame_size().height_px;
    out["same_sensor"] = same_sensor(*recording);
    out["event_width_px"] = recording->event_size().width_px;
    out["event_window_ms"] = EventPictures::kWindow_us / kNsPerUs;
  }
  out["list"] = std::move(list);
  return out;
}

}  // namespace pled::report

#include "pled_vins/pipeline/event_feed.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

namespace {

using namespace pled;

/// A source whose chunks hold plain Event structs, with faults where a test wants them.
class ScriptedSource final : public EventSource {
 public:
  std::vector<std::vector<Event>> chunks;
  std::optional<Error> failure_at_end;
  std::size_t timeouts_before_second = 0;
  std::size_t gap_before = SIZE_MAX;
  std::size_t released = 0;

  Result<void> start() noexcept override { return {}; }
  Result<RawChunk> acquire(Duration) noexcept override {
    if (next_ == 1 && timeouts_before_second > 0) {
      --timeouts_before_second;
      return ErrorCode::kTimeout;
    }
    if (next_ == chunks.size()) return failure_at_end.value_or(Error{ErrorCode::kEndOfStream, 0});
    const bool gap = next_ == gap_before;
    const std::vector<Event>& chunk = chunks[next_++];
    return RawChunk{std::as_bytes(std::span(chunk)), {}, gap};
  }
  void release() noexcept override { ++released; }
  void stop() noexcept override {}

 private:
  std::size_t next_ = 0;
};

class CopyDecoder final : public EventDecoder {
 public:
  std::size_t resyncs = 0;
  std::size_t ends = 0;

  DecodeStep decode(std::span<const std::byte> bytes, std::span<Event> out) noexcept override {
    const std::size_t n = std::min(bytes.size() / sizeof(Event), out.size());
    if (n > 0) std::memcpy(out.data(), bytes.data(), n * sizeof(Event));
    return {n * sizeof(Event), n};
  }
  void resynchronise() noexcept override { ++resyncs; }
  void finish() noexcept override { ++ends; }
  [[nodiscard]] const DecoderFaults& faults() const noexcept override { return faults_; }

 private:
  DecoderFaults faults_;
};

std::vector<Event> events_at(std::initializer_list<std::int64_t> times_us) {
  std::vector<Event> events;
  for (const std::int64_t t : times_us) events.push_back({Timestamp{t}, 1, 2, Polarity::kOn});
  return events;
}

std::vector<std::int64_t> drain(EventFeed& feed, std::int64_t until_us) {
  std::vector<std::int64_t> times;
  for (auto events = feed.next(Timestamp{until_us}); !events.empty();
       events = feed.next(Timestamp{until_us}))
    for (const Event& e : events) times.push_back(e.t.us);
  return times;
}

}  // namespace

TEST_SUITE("pipeline.event_feed") {
  TEST_CASE("events come up to the asked time and no further, across chunks") {
    ScriptedSource source;
    source.chunks = {events_at({1, 5, 9}), events_at({10, 20}), events_at({20, 30})};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 9) == std::vector<std::int64_t>{1, 5, 9});
    CHECK(drain(*feed, 9).empty());
    CHECK(drain(*feed, 20) == std::vector<std::int64_t>{10, 20, 20});
    CHECK_FALSE(feed->ended());
    CHECK(decoder.ends == 0);
    CHECK(drain(*feed, 100) == std::vector<std::int64_t>{30});
    CHECK(feed->ended());
    CHECK(decoder.ends == 1);
    CHECK_FALSE(feed->failure().has_value());
    CHECK(source.released == 3);
  }

  TEST_CASE("more events than one batch holds all arrive, in order") {
    ScriptedSource source;
    std::vector<Event> many;
    for (int i = 0; i < 20000; ++i) many.push_back({Timestamp{i}, 0, 0, Polarity::kOff});
    source.chunks = {many};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    const std::vector<std::int64_t> times = drain(*feed, 1'000'000);
    REQUIRE(times.size() == many.size());
    CHECK(std::is_sorted(times.begin(), times.end()));
  }

  TEST_CASE("a source that breaks is reported and what came before it is not lost") {
    ScriptedSource source;
    source.chunks = {events_at({1, 2})};
    source.failure_at_end = Error{ErrorCode::kIoFailure, 5};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 100) == std::vector<std::int64_t>{1, 2});
    CHECK(feed->ended());
    REQUIRE(feed->failure().has_value());
    CHECK(feed->failure()->code == ErrorCode::kIoFailure);
  }

  TEST_CASE("a timeout gives nothing now and loses nothing later") {
    ScriptedSource source;
    source.chunks = {events_at({1}), events_at({2})};
    source.timeouts_before_second = 1;
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 10) == std::vector<std::int64_t>{1});
    CHECK_FALSE(feed->ended());
    CHECK(drain(*feed, 10) == std::vector<std::int64_t>{2});
  }

  TEST_CASE("a chunk after a gap makes the decoder resynchronise") {
    ScriptedSource source;
    source.chunks = {events_at({1}), events_at({2})};
    source.gap_before = 1;
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 10).size() == 2);
    CHECK(decoder.resyncs == 1);
  }

  TEST_CASE("behind a clock that was set back events come when who asks went back too") {
    ScriptedSource source;
    // Once in the middle of a batch, once between two.
    source.chunks = {events_at({100'000'000, 100'040'000, 100'080'000, 10'000, 60'000}),
                     events_at({110'000, 160'000}), events_at({90'000'000}), events_at({20'000})};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 100'050'000) == std::vector<std::int64_t>{100'000'000, 100'040'000});
    // What is left of the old clock was passed by.
    CHECK(drain(*feed, 50'000) == std::vector<std::int64_t>{10'000});
    CHECK(drain(*feed, 150'000) == std::vector<std::int64_t>{60'000, 110'000});
    CHECK(drain(*feed, 91'000'000) == std::vector<std::int64_t>{160'000, 90'000'000});
    CHECK(drain(*feed, 50'000) == std::vector<std::int64_t>{20'000});
    CHECK(feed->ended());
  }

  TEST_CASE("a silence after a clock was set back loses no event") {
    ScriptedSource source;
    source.chunks = {events_at({100'000'000, 100'080'000, 10'000}),
                     events_at({60'000'000, 100'080'000})};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 100'050'000).size() == 1);
    CHECK(drain(*feed, 50'000) == std::vector<std::int64_t>{10'000});
    for (std::int64_t t = 100'000; t < 60'000'000; t += 50'000) REQUIRE(drain(*feed, t).empty());
    CHECK(drain(*feed, 60'000'000) == std::vector<std::int64_t>{60'000'000});
    CHECK(drain(*feed, 100'100'000) == std::vector<std::int64_t>{100'080'000});
  }

  TEST_CASE("what is left of an old clock may be many batches") {
    ScriptedSource source;
    std::vector<Event> old;
    for (int i = 0; i < 30'000; ++i) old.push_back({Timestamp{100'000'000 + i}, 0, 0, {}});
    source.chunks = {old, events_at({1'000, 2'000})};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 100'000'000).size() == 1);
    CHECK(drain(*feed, 1'500) == std::vector<std::int64_t>{1'000});
    CHECK(drain(*feed, 2'500) == std::vector<std::int64_t>{2'000});
  }

  TEST_CASE("events behind a step back that nobody else makes come one call later") {
    ScriptedSource source;
    source.chunks = {events_at({100'000'000, 10'000, 20'000})};
    CopyDecoder decoder;
    auto feed = std::make_unique<EventFeed>();
    feed->connect(source, decoder);
    CHECK(drain(*feed, 100'050'000) == std::vector<std::int64_t>{100'000'000});
    CHECK(drain(*feed, 100'050'000).empty());
    CHECK_FALSE(feed->ended());
    CHECK(drain(*feed, 100'100'000) == std::vector<std::int64_t>{10'000, 20'000});
    CHECK(feed->ended());
  }

  TEST_CASE("stamps far ahead hold up nothing when time goes on behind them, those alone do") {
    for (const std::size_t wild : {std::size_t{1}, std::size_t{66}, std::size_t{5'000}}) {
      CAPTURE(wild);
      ScriptedSource source;
      source.chunks = {events_at({10'000}),
                       std::vector<Event>(wild, Event{Timestamp{9'000'000'000}, 0, 0, {}}),
                       events_at({20'000, 30'000}), events_at({8'000'000})};
      CopyDecoder decoder;
      auto feed = std::make_unique<EventFeed>();
      feed->connect(source, decoder);
      CHECK(drain(*feed, 25'000) == std::vector<std::int64_t>{10'000, 20'000});
      CHECK(drain(*feed, 50'000) == std::vector<std::int64_t>{30'000});
      CHECK(drain(*feed, 75'000).empty());
      CHECK_FALSE(feed->ended());
      CHECK(drain(*feed, 8'000'000) == std::vector<std::int64_t>{8'000'000});
      CHECK(feed->ended());
    }
  }

  TEST_CASE("a feed without a source has ended") {
    const auto feed = std::make_unique<EventFeed>();
    CHECK(feed->ended());
    CHECK(feed->next(Timestamp{100}).empty());
  }
}

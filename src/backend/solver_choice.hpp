#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "pled_vins/backend/window.hpp"

namespace pled {

/// Chooses the points, or the lines, of the next solve: of those seen often enough that have a
/// place, at most Most, living and long ones first. Rejected ones keep their weight, the others
/// wait for a new one.
/// @param newest      index of the window's newest state: who is seen from it lives
/// @param find_place  given a landmark, tries to give it a place; returns whether it has one
/// @returns how many
template <std::size_t Most, typename Landmarks, typename FindPlace>
std::size_t choose_for_solver(Landmarks& landmarks, std::size_t newest,
                              std::size_t min_observations, const FindPlace& find_place) noexcept {
  struct Candidate {
    std::size_t index;
    std::size_t rank;
  };
  std::array<Candidate, Landmarks::capacity()> candidates;
  std::size_t n = 0;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    auto& landmark = landmarks[i];
    landmark.in_solver = false;
    if (landmark.rejected) continue;
    landmark.weight = kNoEvidence;
    if (landmark.observations.size() < min_observations || !find_place(landmark)) continue;
    const bool live = landmark.observations.back().state == newest;
    candidates[n++] = {i, landmark.observations.size() + (live ? 100U : 0U)};
  }
  const std::size_t used = std::min(n, Most);
  std::sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(n),
            [](const Candidate& a, const Candidate& b) {
              return a.rank != b.rank ? a.rank > b.rank : a.index < b.index;
            });
  for (std::size_t k = 0; k < used; ++k) landmarks[candidates[k].index].in_solver = true;
  return used;
}

}  // namespace pled

// The cameras of the scene aprs_lab against frames recorded in the laboratory: which share of the
// frames shows a thing, how its position scatters, and how its yaw.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

struct Sighting {
  std::string type;  ///< P, PT or KT
  double x_mm = 0, y_mm = 0, yaw_rad = 0;
};
using Frame = std::vector<std::pair<std::string, Sighting>>;  ///< by sku

/// The number that a text is; recordings of a terminal have broken lines, too.
std::optional<double> number_in(const std::string& text) {
  std::istringstream in(text);
  double value = 0;
  if (!(in >> value) || in.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  return value;
}

/// Six fields a thing, a frame a line; a thing without place was not detected.
std::vector<Frame> read_frames(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<Frame> frames;
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
      if (c == ',') {
        fields.emplace_back();
      } else {
        fields.back() += c;
      }
    }
    Frame frame;
    for (std::size_t i = 0; i + 5 < fields.size(); i += 6) {
      const auto yaw = number_in(fields[i + 1]), x = number_in(fields[i + 2]);
      const auto y = number_in(fields[i + 3]);
      if (yaw && x && y) frame.push_back({fields[i], {fields[i + 5], *x, *y, *yaw}});
    }
    if (!frame.empty()) frames.push_back(std::move(frame));
  }
  return frames;
}

/// One thing through all frames.
struct Track {
  std::string name;
  std::vector<Sighting> seen;

  /// Standard deviation of x and y together, of the sightings at the commonest yaw.
  [[nodiscard]] double scatter_mm() const {
    double best = 0;
    std::size_t most = 0;
    for (const auto& reference : seen) {
      std::vector<Sighting> same;
      std::ranges::copy_if(seen, std::back_inserter(same), [&](const Sighting& s) {
        return std::abs(std::remainder(s.yaw_rad - reference.yaw_rad, 2 * std::numbers::pi)) < 0.1;
      });
      if (reference.type == "P") same = seen;
      if (same.size() <= most || same.size() < 3) continue;
      most = same.size();
      double x = 0, y = 0, squares = 0;
      for (const auto& s : same) x += s.x_mm, y += s.y_mm;
      x /= static_cast<double>(most);
      y /= static_cast<double>(most);
      for (const auto& s : same) squares += std::pow(s.x_mm - x, 2) + std::pow(s.y_mm - y, 2);
      best = std::sqrt(squares / (2 * (static_cast<double>(most) - 1)));
    }
    return best;
  }
  /// Share of the sightings whose yaw is more than 45 degrees from the commonest.
  [[nodiscard]] double turned() const {
    std::size_t fewest = seen.size();
    for (const auto& reference : seen) {
      const auto off = static_cast<std::size_t>(std::ranges::count_if(seen, [&](const auto& s) {
        return std::abs(std::remainder(s.yaw_rad - reference.yaw_rad, 2 * std::numbers::pi)) >
               std::numbers::pi / 4;
      }));
      fewest = std::min(fewest, off);
    }
    return static_cast<double>(fewest) / static_cast<double>(seen.size());
  }
};

/// Things of one name stand farther apart than any of them moves.
std::vector<Track> tracks_of(const std::vector<Frame>& frames) {
  constexpr double kSame_mm = 8;
  std::vector<Track> tracks;
  for (const auto& frame : frames) {
    for (const auto& [name, s] : frame) {
      const auto found = std::ranges::find_if(tracks, [&name = name, &s = s](const Track& t) {
        return t.name == name &&
               std::hypot(t.seen[0].x_mm - s.x_mm, t.seen[0].y_mm - s.y_mm) < kSame_mm;
      });
      if (found == tracks.end()) {
        tracks.push_back({name, {s}});
      } else {
        found->seen.push_back(s);
      }
    }
  }
  return tracks;
}

struct Look {
  double scatter_mm = 0;    ///< median of the things
  double shown = 1;         ///< share of the frames in which the rarest thing is
  double gear_yaw_rad = 0;  ///< farthest from 0
  double part_trays_turned = 0, kits_turned = 0;  ///< mean
};

Look look_at(const char* what, const std::vector<Frame>& frames) {
  Look look;
  std::vector<double> scatters;
  int part_trays = 0, kits = 0;
  for (const auto& track : tracks_of(frames)) {
    look.shown = std::min(
        look.shown, static_cast<double>(track.seen.size()) / static_cast<double>(frames.size()));
    scatters.push_back(track.scatter_mm());
    const std::string& type = track.seen[0].type;
    if (type == "P") {
      for (const auto& s : track.seen) {
        look.gear_yaw_rad = std::max(look.gear_yaw_rad, std::abs(s.yaw_rad));
      }
    } else if (type == "PT") {
      look.part_trays_turned += track.turned();
      ++part_trays;
    } else {
      look.kits_turned += track.turned();
      ++kits;
    }
  }
  std::ranges::sort(scatters);
  if (!scatters.empty()) look.scatter_mm = scatters[scatters.size() / 2];
  look.part_trays_turned /= std::max(part_trays, 1);
  look.kits_turned /= std::max(kits, 1);
  std::printf(
      "%-28s %3zu frames, %2zu things, in %3.0f %% of them, scatter %.3f mm, gear yaw within "
      "%.2f rad, turned: part trays %2.0f %%, kits %2.0f %%\n",
      what, frames.size(), scatters.size(), 100 * look.shown, look.scatter_mm, look.gear_yaw_rad,
      100 * look.part_trays_turned, 100 * look.kits_turned);
  return look;
}

/// Frames that the camera of a robot at rest sends of the cell at rest.
std::vector<Frame> our_frames(int robot, std::size_t count) {
  CellScript cell(load_scene("aprs_lab"));
  std::vector<Frame> frames;
  std::uint64_t last = 0;
  const auto& bodies = cell.world.description()->bodies;
  cell.advance(1000);
  while (frames.size() < count) {
    cell.advance(10);
    const auto& vision = cell.now.robots[static_cast<std::size_t>(robot)].vision;
    if (vision.number == last) continue;
    last = vision.number;
    Frame frame;
    for (const auto& seen : vision.detections) {
      const auto& body = bodies[static_cast<std::size_t>(seen.body)];
      const char* type = body.kind == api::BodyKind::kGear       ? "P"
                         : body.kind == api::BodyKind::kPartTray ? "PT"
                                                                 : "KT";
      frame.push_back({body.type, {type, 1e3 * seen.x_m, 1e3 * seen.y_m, seen.rotation_rad}});
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

TEST(RecordedVision, TheLaboratorysCamerasScatterAsRecorded) {
  const std::filesystem::path root(APRSIM_REFERENCE_DIR);
  if (root.empty()) GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  const auto folder = root / "aprs/data/vision_recorded";
  std::vector<Look> recorded;
  for (const char* file :
       {"vision_data_2018.csv", "flipping_kit_rotation.csv", "old_2016_vision_data.csv"}) {
    const auto frames = read_frames(folder / file);
    ASSERT_GE(frames.size(), 8U) << file;
    recorded.push_back(look_at(file, frames));
  }
  const auto range = [&](double Look::*value) { return std::ranges::minmax(recorded, {}, value); };
  for (const int robot : {0, 1}) {
    const Look ours = look_at(robot == 0 ? "ours, fanuc" : "ours, motoman", our_frames(robot, 200));
    const auto scatter = range(&Look::scatter_mm);
    EXPECT_GT(ours.scatter_mm, scatter.min.scatter_mm / 1.5);
    EXPECT_LT(ours.scatter_mm, scatter.max.scatter_mm * 1.5);
    const auto yaw = range(&Look::gear_yaw_rad);
    EXPECT_NEAR(ours.gear_yaw_rad, yaw.max.gear_yaw_rad, 0.1);
    EXPECT_EQ(ours.shown, 1);
    const auto turned = range(&Look::part_trays_turned);
    EXPECT_GE(ours.part_trays_turned, turned.min.part_trays_turned);
    EXPECT_LE(ours.part_trays_turned, turned.max.part_trays_turned + 0.1);
    EXPECT_EQ(ours.kits_turned, range(&Look::kits_turned).min.kits_turned);
  }
}

}  // namespace
}  // namespace aprsim::test

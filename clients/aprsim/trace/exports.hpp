#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/wires/outcome.hpp"

/// Exports of a run for other programs. `motion`: a motion file (trace/motion.hpp); empty = only
/// wires and events. Each file is in its place when it is complete; a failed export leaves an older
/// file as it was.
namespace aprsim::trace {

/// Numbers of the messages of an export.
struct Exported {
  std::uint64_t snapshots = 0, wires = 0, events = 0, messages = 0;
};

/// The files that an export to CSV writes in a directory.
[[nodiscard]] std::vector<std::string> csv_files(const std::string& directory);
/// Checks that no file to be written is one of the run's journals, or written twice. Failure:
/// kUsage.
[[nodiscard]] client::Outcome<void> check_exports(const std::string& place,
                                                  const std::vector<std::string>& outputs);

/// Writes joints.csv, bodies.csv, belt.csv, events.csv and wires.csv into a directory, which is
/// created where it is missing: a header line, then a line for each value at each time; SI units,
/// UTF-8.
[[nodiscard]] client::Outcome<Exported> export_csv(const std::string& place,
                                                   const std::string& motion,
                                                   const std::string& directory);

/// Writes one MCAP file (mcap.dev) of JSON messages: /tf (foxglove.FrameTransforms), /scene
/// (foxglove.SceneUpdate), /log (foxglove.Log), /joints, /belt, /events and /wires.
[[nodiscard]] client::Outcome<Exported> export_mcap(const std::string& place,
                                                    const std::string& motion,
                                                    const std::string& file);

/// Writes one HTML page that shows the run without a daemon or a network. `web`: the directory of
/// the page's bundle.
[[nodiscard]] client::Outcome<Exported> export_html(const std::string& place,
                                                    const std::string& motion,
                                                    const std::string& file,
                                                    const std::string& web);

/// A camera and a part of a run.
struct VideoChoice {
  std::string camera;  ///< of the recorded scene
  double rate_hz = 25;
  std::optional<double> from_s, to_s;
};
/// Renders what a camera saw during a run and writes it as MP4 (H.264) by ffmpeg. Failures: kUsage
/// without ffmpeg, for an unknown camera, and as Motion::of.
[[nodiscard]] client::Outcome<Exported> export_video(const std::string& place,
                                                     const VideoChoice& choice,
                                                     const std::string& file);

}  // namespace aprsim::trace

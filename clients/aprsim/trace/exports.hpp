#pragma once

#include <cstdint>
#include <string>

#include "clients/wires/outcome.hpp"

/// A run for other programs. `motion`: a motion file (trace/motion.hpp); empty = only wires and
/// events.
namespace aprsim::trace {

/// What was written.
struct Exported {
  std::uint64_t snapshots = 0, wires = 0, events = 0, messages = 0;
};

/// joints.csv, bodies.csv, belt.csv, events.csv and wires.csv in a directory, which is made when it
/// is not there: a header line, then a line a value of a moment; SI.
[[nodiscard]] client::Outcome<Exported> export_csv(const std::string& place,
                                                   const std::string& motion,
                                                   const std::string& directory);

/// One MCAP file (mcap.dev), of JSON messages: /tf (foxglove.FrameTransforms), /scene
/// (foxglove.SceneUpdate), /log (foxglove.Log), /joints, /belt, /events and /wires.
[[nodiscard]] client::Outcome<Exported> export_mcap(const std::string& place,
                                                    const std::string& motion,
                                                    const std::string& file);

/// One page which shows the run without a daemon or a network. `web`: where the page's bundle is.
[[nodiscard]] client::Outcome<Exported> export_html(const std::string& place,
                                                    const std::string& motion,
                                                    const std::string& file,
                                                    const std::string& web);

}  // namespace aprsim::trace

#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "crcl/status.hpp"
#include "crcl/units.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "server/replay/wire_reply.hpp"

namespace aprsim::server::journal {

/// Recomputes the statuses of a CRCL connection, as far as the cell alone determines them: joints,
/// pose, gripper and speed override. Units are those that fit all statuses so far. Thread: one at a
/// time.
class CrclReplies : public std::enable_shared_from_this<CrclReplies> {
 public:
  /// `robot`: its name.
  explicit CrclReplies(std::string robot);

  /// A document of the client.
  void received(const std::string& document, world::RunTime at);
  /// A document to the client; absent = no status, or its request is unknown.
  [[nodiscard]] std::optional<WireReply> sent(const std::string& document, world::RunTime at);

 private:
  /// Possible units, with the number of documents after which they may apply.
  struct PossibleUnits {
    crcl::Units units;
    std::uint64_t since = 0;
  };
  [[nodiscard]] Deviation deviation(const crcl::Status& recorded, std::uint64_t set_before,
                                    const api::Snapshot& snapshot);
  [[nodiscard]] bool is_status_request(const std::string& document);
  void follow_units(const std::string& document);

  const std::string robot_;
  std::string get_status_;            ///< the latest request, which clients repeat byte by byte
  std::deque<world::RunTime> asked_;  ///< requested statuses
  std::vector<PossibleUnits> units_;
  std::uint64_t sets_ = 0;   ///< documents that may have set units
  std::string status_text_;  ///< the status that is compared
  crcl::Status status_;
  std::shared_ptr<const api::CellDescription> cell_;
  std::optional<std::size_t> index_;             ///< of the robot in that
  std::optional<crcl_server::JointMap> joints_;  ///< of that
};

}  // namespace aprsim::server::journal

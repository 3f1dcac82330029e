#include <filesystem>

#include <fmt/format.h>
#include <fmt/ostream.h>

#include "clients/aprsim/trace/exports.hpp"
#include "clients/aprsim/trace/listing.hpp"
#include "clients/aprsim/trace/motion_reader.hpp"
#include "proto/journal/journal_place.hpp"
#include "world/base/files/draft_file.hpp"

namespace aprsim::trace {
namespace {

namespace fs = std::filesystem;
using client::failed;
using client::FailureKind;

/// Text as a field of RFC 4180.
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

/// One file of the directory.
class Table {
 public:
  Table(const std::string& directory, const std::string& name, const char* header)
      : file_((fs::path(directory) / name).string()) {
    file_.out() << header << '\n';
  }
  template <typename... Arguments>
  void row(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::print(file_.out(), format, std::forward<Arguments>(arguments)...);
  }
  client::Outcome<void> finish() {
    if (auto done = file_.commit(); !done) return failed(FailureKind::kUsage, done.error().message);
    return {};
  }

 private:
  files::DraftFile file_;
};

struct MotionTables {
  Table joints, bodies, belt;

  explicit MotionTables(const std::string& directory)
      : joints(directory, "joints.csv", "time_s,robot,joint,position_rad,velocity_rad_s,torque_nm"),
        bodies(directory, "bodies.csv",
               "time_s,name,type,x_m,y_m,z_m,qx,qy,qz,qw,vx_m_s,vy_m_s,vz_m_s,resting"),
        belt(directory, "belt.csv", "time_s,run,forward,speed_m_s,travel_m,load_kg") {}

  void add(double time_s, const v1::Snapshot& snapshot) {
    for (const auto& robot : snapshot.robots()) {
      for (int i = 0; i < robot.joints_size(); ++i) {
        const auto& joint = robot.joints(i);
        joints.row("{:.3f},{},{},{:.9g},{:.9g},{:.9g}\n", time_s, quoted(robot.name()), i + 1,
                   joint.position_rad(), joint.velocity_rad_s(), joint.torque_nm());
      }
    }
    for (const auto& body : snapshot.bodies()) {
      const auto& at = body.body_in_world().position_m();
      const auto& turn = body.body_in_world().orientation();
      const auto& speed = body.velocity_m_s();
      bodies.row(
          "{:.3f},{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{}\n",
          time_s, quoted(body.name()), quoted(body.type()), at.x(), at.y(), at.z(), turn.x(),
          turn.y(), turn.z(), turn.w(), speed.x(), speed.y(), speed.z(), body.resting() ? 1 : 0);
    }
    if (snapshot.has_conveyor()) {
      const auto& conveyor = snapshot.conveyor();
      belt.row("{:.3f},{},{},{:.9g},{:.9g},{:.6g}\n", time_s, conveyor.run() ? 1 : 0,
               conveyor.forward() ? 1 : 0, conveyor.speed_m_s(), conveyor.travel_m(),
               conveyor.load_kg());
    }
  }
};

}  // namespace

std::vector<std::string> csv_files(const std::string& directory) {
  std::vector<std::string> out;
  for (const char* name : {"joints.csv", "bodies.csv", "belt.csv", "events.csv", "wires.csv"}) {
    out.push_back((fs::path(directory) / name).string());
  }
  return out;
}

client::Outcome<void> check_exports(const std::string& place,
                                    const std::vector<std::string>& outputs) {
  const auto inputs = aprsim::journal::files_of_run(place);
  if (!inputs) return failed(FailureKind::kUsage, inputs.error().message);
  if (auto apart = files::check_outputs(*inputs, outputs); !apart) {
    return failed(FailureKind::kUsage, apart.error().message);
  }
  return {};
}

client::Outcome<Exported> export_csv(const std::string& place, const std::string& motion,
                                     const std::string& directory) {
  std::error_code status;
  fs::create_directories(directory, status);
  if (status) return failed(FailureKind::kUsage, directory + ": " + status.message());
  Exported out;
  if (!motion.empty()) {
    MotionTables tables(directory);
    const auto read = read_motion(
        motion, [&](double time_s, const v1::Snapshot& snapshot, const v1::MotionHeader*) {
          tables.add(time_s, snapshot);
          ++out.snapshots;
        });
    if (!read) return failed(FailureKind::kUsage, read.error().message);
    for (Table* table : {&tables.joints, &tables.bodies, &tables.belt}) {
      if (auto done = table->finish(); !done) return tl::unexpected(done.error());
    }
  }
  Table events(directory, "events.csv", "time_s,what");
  Table wires(directory, "wires.csv", "time_s,wire,connection,direction,what");
  const auto listed = list_trace(place, {.polls = true}, [&](const ListedLine& line) {
    if (line.wire == "cell") {
      events.row("{:.3f},{}\n", line.time_s, quoted(line.text));
      ++out.events;
    } else {
      wires.row("{:.3f},{},{},{},{}\n", line.time_s, quoted(line.wire), line.connection,
                line.direction, quoted(line.text));
      ++out.wires;
    }
  });
  if (!listed) return failed(FailureKind::kUsage, listed.error().message);
  for (Table* table : {&events, &wires}) {
    if (auto done = table->finish(); !done) return tl::unexpected(done.error());
  }
  return out;
}

}  // namespace aprsim::trace

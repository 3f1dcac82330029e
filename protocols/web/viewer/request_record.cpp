#include "protocols/web/viewer/request_record.hpp"

#include <chrono>
#include <string_view>
#include <utility>

#include "protocols/web/http/request_text.hpp"

namespace aprsim::web {
namespace {

/// Whether a request renews an unchanged jog, which is recorded once only.
bool is_repeated_jog(Viewer& viewer, const v1::ViewerRequest& request, const std::string& state) {
  if (!request.has_jog()) return false;
  std::string jog = request.jog().SerializeAsString() + state;
  if (viewer.recorded_jog == jog) return true;
  viewer.recorded_jog = std::move(jog);
  return false;
}

void audit(protocols::AuditLog& log, const Viewer& viewer, const std::string& kind,
           const protocols::WireEvent& event, const Result<void>& done) {
  log.write({.wire = "web",
             .peer = viewer.peer(),
             .identity = viewer.caller.text(),
             .command = kind,
             .request = event.data,
             .outcome = done ? "ok" : done.error().message,
             .time = event.time});
}

}  // namespace

std::string kind_of(const v1::ViewerRequest& request) {
  const auto* field = v1::ViewerRequest::descriptor()->FindFieldByNumber(request.body_case());
  return field == nullptr ? "" : field->name();
}

void record(const WebServerOptions& options, const api::CellDescription& cell, Viewer& viewer,
            const v1::ViewerRequest& request, const Result<void>& done) {
  const protocols::ListenerOptions& listener = options.listener;
  const std::string error = done ? "" : done.error().message;
  if (listener.trace != nullptr) viewer.trace.received(request.SerializeAsString(), error);
  if (!done && listener.refusals != nullptr) {
    listener.refusals->refused("web", kind_of(request) + " of " + viewer.peer() + ": " + error);
  }
  if (is_repeated_jog(viewer, request, error)) return;
  protocols::WireEvent event{.source = "page",
                             .peer = viewer.peer(),
                             .from_client = true,
                             .time = std::chrono::system_clock::now(),
                             .type = title_of(request, cell),
                             .id = request.id(),
                             .state = error,
                             .data = json_of(request)};
  if (listener.audit != nullptr) audit(*listener.audit, viewer, kind_of(request), event, done);
  const bool of_the_belt = request.has_conveyor() || request.has_write_register();
  if (options.modbus_tap && of_the_belt) options.modbus_tap->record(event);
  if (options.crcl_tap) options.crcl_tap->record(std::move(event));
}

}  // namespace aprsim::web

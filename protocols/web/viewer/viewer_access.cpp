#include "protocols/web/viewer/viewer_access.hpp"

#include <algorithm>
#include <utility>

#include "protocols/access/call_roles.hpp"

namespace aprsim::web {

protocols::Role ViewerAccess::role_of(const Viewer& viewer) const {
  const protocols::Role role = options_.listener.access->still(viewer.caller);
  return commands() ? role : std::min(role, protocols::Role::kView);
}

v1::Permission ViewerAccess::permission(const Viewer& viewer) const {
  v1::Permission permission;
  permission.set_role(std::string(protocols::to_text(viewer.role)));
  permission.set_name(viewer.caller.name);
  permission.set_control(viewer.role >= protocols::Role::kOperate);
  permission.set_token_helps(options_.listener.access->has_credentials() &&
                             viewer.role <
                                 (commands() ? protocols::Role::kAdmin : protocols::Role::kView));
  if (viewer.role < protocols::Role::kView) {
    permission.set_reason("This view needs an access token.");
  } else if (!options_.read_only.empty()) {
    permission.set_reason(options_.read_only);
  } else if (!options_.control) {
    permission.set_reason("This view is read-only (web.control is false).");
  } else if (permission.control()) {
    return permission;
  } else if (permission.token_helps()) {
    permission.set_reason("Control needs the access token.");
  } else {
    permission.set_reason(
        "From other machines this view is read-only: the daemon knows no tokens (access.file).");
  }
  return permission;
}

Result<void> ViewerAccess::check_role(const Viewer& viewer, const std::string& request) {
  const protocols::Role needed = protocols::role_needed("aprsim.v1.ViewerRequest/" + request);
  if (!commands() && needed > protocols::Role::kView) {
    return fail(ErrorCode::kFailedPrecondition, "permission", permission(viewer).reason());
  }
  protocols::Caller caller = viewer.caller;
  caller.role = role_of(viewer);
  const auto refusal = options_.listener.access->refusal(caller, request, needed);
  if (!refusal) return {};
  log_.warn(viewer.peer() + " is refused: " + refusal->message);
  return fail(ErrorCode::kFailedPrecondition, "permission", refusal->message);
}

Result<void> ViewerAccess::authenticate(Viewer& viewer, const std::string& token) {
  using Problem = protocols::Caller::Problem;
  if (!options_.listener.access->has_credentials()) return {};
  protocols::Caller caller = options_.listener.access->identify(
      protocols::host_of(viewer.peer()),
      {.token = token, .certificate = viewer.caller.certificate});
  switch (caller.problem) {
    case Problem::kTooManyAttempts:
      return fail(ErrorCode::kUnavailable, "token",
                  "too many wrong tokens from this address; wait before the next one");
    case Problem::kWrongToken:
      return refuse_token(viewer, "a wrong token", "wrong token");
    case Problem::kExpired:
      return refuse_token(viewer, "an expired token, " + caller.name, "expired token");
    case Problem::kNone:
      break;
  }
  viewer.caller = std::move(caller);
  return {};
}

tl::unexpected<Error> ViewerAccess::refuse_token(const Viewer& viewer, const std::string& kind,
                                                 const std::string& why) {
  log_.warn("viewer " + viewer.peer() + " gave " + kind);
  if (auto* const refusals = options_.listener.refusals) {
    refusals->refused("web", "token of " + viewer.peer() + ": " + why);
  }
  return fail(ErrorCode::kInvalidArgument, "token", why);
}

}  // namespace aprsim::web

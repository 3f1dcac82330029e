#pragma once

#include <string>

#include "protocols/net/limited_log.hpp"
#include "protocols/web/viewer/viewer.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Permissions of viewers. Thread: the server's.
class ViewerAccess {
 public:
  explicit ViewerAccess(const WebServerOptions& options) : options_(options) {}

  /// Role of the viewer at present: tokens expire, and are removed.
  [[nodiscard]] protocols::Role role_of(const Viewer& viewer) const;
  /// The viewer's role as it is told, with the reason why there is not more.
  [[nodiscard]] v1::Permission permission(const Viewer& viewer) const;
  /// Whether a viewer may make requests of that kind. Error: kFailedPrecondition with the reason.
  [[nodiscard]] Result<void> check_role(const Viewer& viewer, const std::string& request);
  /// Makes the viewer the token's owner. Errors, field "token": kUnavailable after too many
  /// attempts, kInvalidArgument for a wrong or expired one.
  [[nodiscard]] Result<void> authenticate(Viewer& viewer, const std::string& token);

 private:
  /// Whether there is anything that a viewer may command.
  [[nodiscard]] bool commands() const { return options_.control && options_.read_only.empty(); }
  [[nodiscard]] tl::unexpected<Error> refuse_token(const Viewer& viewer, const std::string& kind,
                                                   const std::string& why);

  const WebServerOptions& options_;
  protocols::LimitedLog log_{"web"};
};

}  // namespace aprsim::web

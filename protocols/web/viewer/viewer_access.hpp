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

  /// Current role of the viewer; tokens may expire or be removed.
  [[nodiscard]] protocols::Role role_of(const Viewer& viewer) const;
  /// The viewer's role with the reason why it has no higher one.
  [[nodiscard]] v1::Permission permission(const Viewer& viewer) const;
  /// Checks that a viewer may send requests of this kind. Error: kFailedPrecondition with the
  /// reason.
  [[nodiscard]] Result<void> check_role(const Viewer& viewer, const std::string& request);
  /// Gives the viewer the role of the token. Errors, field "token": kUnavailable after too many
  /// attempts, kInvalidArgument for a wrong or expired one.
  [[nodiscard]] Result<void> authenticate(Viewer& viewer, const std::string& token);

 private:
  /// Whether viewers may send any command.
  [[nodiscard]] bool commands() const { return options_.control && options_.read_only.empty(); }
  [[nodiscard]] tl::unexpected<Error> refuse_token(const Viewer& viewer, const std::string& kind,
                                                   const std::string& why);

  const WebServerOptions& options_;
  protocols::LimitedLog log_{"web"};
};

}  // namespace aprsim::web

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "protocols/access/access.hpp"

namespace aprsim::test {

/// The rules with one token for each role, which is called as the role and reads ROLE-token, and
/// "right-token" for the role admin.
inline protocols::AccessRules rules_with_tokens() {
  using protocols::Role;
  protocols::AccessRules rules{.local = Role::kView, .others = Role::kView};
  const auto add = [&rules](const std::string& name, const std::string& token, Role role) {
    const std::string salt = "salt of " + name;
    rules.tokens.push_back({name, role, salt, protocols::digest_of(salt, token)});
  };
  for (const Role role : {Role::kView, Role::kOperate, Role::kInject, Role::kAdmin}) {
    const std::string name(protocols::to_text(role));
    add(name, name + "-token", role);
  }
  add("right", "right-token", Role::kAdmin);
  return rules;
}

inline std::shared_ptr<protocols::Access> access_with_tokens() {
  return std::make_shared<protocols::Access>(rules_with_tokens());
}

}  // namespace aprsim::test

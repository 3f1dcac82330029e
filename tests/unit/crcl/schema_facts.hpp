#pragma once

#include <map>
#include <string>
#include <vector>

namespace aprsim::crcl {

/// The top-level declarations of schema documents, by kind and name, one line each: "complexType
/// PointType" -> "extends DataThingType: X xs:double 1..1, ...". Documentation, order of
/// declarations, includes and which file something stands in do not show.
[[nodiscard]] std::map<std::string, std::string> schema_facts(
    const std::vector<std::string>& documents);

}  // namespace aprsim::crcl

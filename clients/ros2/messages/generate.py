#!/usr/bin/env python3
"""Makes of definitions.txt an IDL file with ROS 2's names of types in DDS and a C++ header with their type
hashes (REP 2011, version 1).

usage: generate.py DEFINITIONS IDL HEADER"""

import hashlib
import json
import re
import sys

# Number of the type in type_description_interfaces/msg/FieldType, type of IDL.
BASIC = {
    "int8": (2, "char"),
    "uint8": (3, "octet"),
    "int16": (4, "short"),
    "uint16": (5, "unsigned short"),
    "int32": (6, "long"),
    "uint32": (7, "unsigned long"),
    "int64": (8, "long long"),
    "uint64": (9, "unsigned long long"),
    "float32": (10, "float"),
    "float64": (11, "double"),
    "char": (3, "octet"),  # ROS's char is an unsigned byte
    "bool": (15, "boolean"),
    "string": (17, "string"),
}
NESTED, BOUNDED_STRING = 1, 21
ARRAY, SEQUENCE = 48, 144  # added to the number
# The header of ROS 2's CycloneDDS before requests and responses, which is no part of the type.
SERVICE_HEADER = "  unsigned long long rmw_client;\n  long long rmw_sequence;\n"
FIELD = re.compile(r"(?P<type>[\w/]+)(?:<=(?P<bound>\d+))?(?P<list>\[(?P<size>\d*)\])? (?P<name>\w+)$")


def read_definitions(text):
    """{type: [match of FIELD, ...]} in the order of the file, in which a type stands before its users."""
    types = {}
    for block in re.sub(r"(?m)^#.*\n?", "", text).split("\n\n"):
        lines = block.split()
        if not lines:
            continue
        name, *fields = block.strip().splitlines()
        found = [FIELD.match(line) for line in fields or ["uint8 structure_needs_at_least_one_member"]]
        for line, field in zip(fields, found):
            if not field or (field["type"] not in BASIC and field["type"] not in types):
                raise SystemExit(f"{name}: found {line!r}, expected a field of a known type")
        types[name] = found
    return types


def described(name, fields):
    """A type as type_description_interfaces/msg/IndividualTypeDescription."""
    out = []
    for field in fields:
        number = BASIC[field["type"]][0] if field["type"] in BASIC else NESTED
        if field["bound"]:
            number = BOUNDED_STRING
        if field["list"]:
            number += ARRAY if field["size"] else SEQUENCE
        out.append({
            "name": field["name"],
            "type": {
                "type_id": number,
                "capacity": int(field["size"] or 0),
                "string_capacity": int(field["bound"] or 0),
                "nested_type_name": "" if field["type"] in BASIC else field["type"],
            },
        })
    return {"type_name": name, "fields": out}


def users(name, types, found=None):
    """The names of all types that a type consists of."""
    found = set() if found is None else found
    for field in types[name]:
        if field["type"] not in BASIC and field["type"] not in found:
            found.add(field["type"])
            users(field["type"], types, found)
    return found


def type_hash(name, types):
    """The type's hash as ROS 2 writes it."""
    description = {
        "type_description": described(name, types[name]),
        "referenced_type_descriptions": [described(part, types[part]) for part in sorted(users(name, types))],
    }
    return "RIHS01_" + hashlib.sha256(json.dumps(description).encode()).hexdigest()


def idl_field(field):
    """A field in IDL."""
    kind = BASIC[field["type"]][1] if field["type"] in BASIC else idl_name(field["type"])
    if field["bound"]:
        kind += f"<{field['bound']}>"
    if not field["list"]:
        return f"{kind} {field['name']};"
    if field["size"]:
        return f"{kind} {field['name']}[{field['size']}];"
    return f"sequence<{kind}> {field['name']};"


def idl_name(name):
    """A type's name in DDS."""
    package, kind, own = name.split("/")
    return f"{package}::{kind}::dds_::{own}_"


def main():
    definitions, idl, header = sys.argv[1:]
    with open(definitions) as file:
        types = read_definitions(file.read())
    with open(idl, "w") as file:
        for name, fields in types.items():
            package, kind, own = name.split("/")
            file.write(f"module {package} {{ module {kind} {{ module dds_ {{\nstruct {own}_ {{\n")
            if own.endswith(("_Request", "_Response")):
                file.write(SERVICE_HEADER)
            file.writelines(f"  {idl_field(field)}\n" for field in fields)
            file.write("};\n}; }; };\n")
    with open(header, "w") as file:
        file.write("#pragma once\n\nnamespace aprsim::ros2::type_hash {\n\n")
        for name in types:
            file.write(f"/// {name}\ninline constexpr const char* k_{name.replace('/', '_')} =\n")
            file.write(f'    "{type_hash(name, types)}";\n')
        file.write("\n}  // namespace aprsim::ros2::type_hash\n")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Makes a recording for test_recordings.py from a session that tests/clients/run kept: the client's input, chunk by
chunk, and the answers of the daemon that the client waited for.

usage: tests/clients/record.py KEPT_FOLDER > tests/clients/recordings/NAME.txt"""

import json
import pathlib
import re
import sys

ENDS = ("CRCL_Done", "CRCL_Error")


# Common parts of all documents of NIST's Java clients.
PHRASES = {
    "B": '<?xml version="1.0" encoding="UTF-8" standalone="yes"?><CRCLCommandInstance><CRCLCommand xsi:type="',
    "I": 'Type" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><CommandID>',
    "E": "</CRCLCommand></CRCLCommandInstance>",
    "N": "<ReportTorqueOrForce>false</ReportTorqueOrForce><ReportVelocity>true</ReportVelocity>",
}


def escape(data):
    """Bytes as one line of printable ASCII, with the phrases shortened."""
    text = "".join(chr(b) if 32 <= b < 127 and b != 92 else f"\\x{b:02x}" for b in data)
    for name, phrase in PHRASES.items():
        text = text.replace(phrase, "\\" + name)
    return text


def field(name, text):
    found = re.search(f"<{name}>([^<]*)<", text)
    return found.group(1) if found else ""


class Recorder:
    def __init__(self, chunks):
        self.lines = []
        self.at = 0.0  # of the last line that is not a poll
        self.polls = {}  # last poll of each connection
        self.text = {}  # of each connection, from the daemon, not yet a whole status
        self.state = {}  # by connection
        for chunk in chunks:
            data = None if chunk["data"] is None else chunk["data"].encode("latin-1")
            kind = chunk["target"].split(".")[0]
            if data is None:
                self.put("open", chunk, chunk["target"])
            elif chunk["from"] == "client":
                self.sent(chunk, data, kind)
            elif data:
                getattr(self, f"answer_{kind}")(chunk, data)

    def put(self, verb, chunk, text):
        gap_ms = round(1e3 * (chunk["at"] - self.at))
        self.at = chunk["at"]
        self.lines.append(f"{verb} {chunk['connection']} {gap_ms} {text}".rstrip())

    def sent(self, chunk, data, kind):
        number = chunk["connection"]
        if not data:
            self.put("close", chunk, "")
            return
        poll = kind == "crcl" and data.count(b"<CRCLCommandInstance") == 1 and b'"GetStatusType"' in data
        if poll and self.polls.get(number) == data:
            return
        if poll:
            self.polls[number] = data
            self.lines.append(f"poll {number} 0 {escape(data)}")
        else:
            self.polls.pop(number, None)
            self.put("send", chunk, escape(data))

    def answer_crcl(self, chunk, data):
        number = chunk["connection"]
        *whole, rest = (self.text.get(number, "") + data.decode()).split("</CRCLStatus>")
        self.text[number] = rest
        for text in whole:
            state = (field("CommandID", text), field("CommandState", text))
            if state != self.state.get(number) and state[1] in ENDS:
                # The client continues at once or after its own delay, which counts from here.
                self.put("status", chunk, " ".join(state))
            self.state[number] = state

    def answer_modbus(self, chunk, data):
        self.put("answer", chunk, escape(data))

    def answer_vision(self, chunk, data):
        """Records the names in the first line of each feed; the line may come in several pieces."""
        number = chunk["connection"]
        if self.text.get(number) is None and number in self.text:
            return
        line, end, _ = (self.text.get(number, "") + data.decode()).partition("\n")
        self.text[number] = None if end else line
        if end:
            self.put("seen", chunk, ",".join(line.split(",")[:-1:6]))


def main():
    folder = pathlib.Path(sys.argv[1])
    with open(folder / "exchange.jsonl", encoding="utf-8") as file:
        chunks = [json.loads(line) for line in file]
    end = json.loads((folder / "end.json").read_text(encoding="utf-8"))
    print("\n".join(["# " + end["session"], *(f"option {option}" for option in end["options"])]))
    print("\n".join(f"phrase {name} {phrase}" for name, phrase in PHRASES.items()))
    print("\n".join(Recorder(chunks).lines))
    for robot, pose in end["tools_mm"].items():
        print(f"tool {robot} " + " ".join(f"{value:.2f}" for value in pose))
    for gear, place in end["gears_mm"].items():
        print(f"gear {gear} " + " ".join(f"{value:.1f}" for value in place))
    if end["belt_m"] is not None:
        print(f"belt {end['belt_m']:.4f}")


if __name__ == "__main__":
    main()

"""Drafts a signal map for a log: wheel speeds, pressures, acceleration, yaw rate and speed by the names of its signals.

Names are compared word by word. What is drafted is a proposal: the user looks it through, and the doctor judges it.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from friction_adapter.signal_map import QUANTITIES
from friction_adapter.unit_table import UNITS, unit_named
from friction_bags.importers.signal_list import ListedSignal
from friction_bags.importers.table import is_time

_PLACES: Final = {
    "front_left": ("fl", "lf", "vl", "frontleft", "leftfront", "fleft"),
    "front_right": ("fr", "rf", "vr", "frontright", "rightfront", "fright"),
    "rear_left": ("rl", "lr", "hl", "rearleft", "leftrear", "rleft"),
    "rear_right": ("rr", "hr", "rearright", "rightrear", "rright"),
}
_SIDES: Final = frozenset(("front", "rear", "left", "right"))
_WORD: Final = re.compile(r"[A-Z]?[a-zäöüß]+|[A-Z]+(?![a-z])|\d+")
_OTHER: Final = frozenset(
    "temp temperature torque trq tq status valid quality qf counter checksum crc tire tyre susp damper covariance raw "
    "target cmd request req slip direction angle steer steering pedal offset".split()
)
"""Words of signals that are none of those looked for."""
_SPEED: Final = frozenset("speed spd velocity vel omega rpm ws v vx vxx kmph kph radps".split())
_WHEEL: Final = frozenset("wheel whl w rad wheels".split())
_PRESSURE: Final = frozenset("pressure press pres p prs druck brkpres".split())
_ACCELERATION: Final = frozenset("acceleration acc accel accelerometer ax ay beschleunigung".split())
_ALONG: Final = frozenset("longitudinal long lon lgt x ax laengs längs".split())
_ACROSS: Final = frozenset("lateral lat y ay quer".split())
_CAR: Final = frozenset("vehicle veh car ground gps vx longitudinal long lon chassis fahrzeug".split())
_TURNING: Final = frozenset("yaw yawrate gyro angular gier".split())
_BRAKE: Final = frozenset("brake brk master mcp cyl bremse line".split())


@dataclass(frozen=True)
class _Rule:
    """Words by which a signal is a quantity."""

    quantity: str
    every: tuple[frozenset[str], ...]
    """Of each of these there must be one."""
    none: frozenset[str] = frozenset()


_RULES: Final = (
    _Rule("brake_pressure", (_PRESSURE,), _SPEED),
    _Rule("wheel_speed", (_WHEEL | _SPEED,), _PRESSURE),
    _Rule("yaw_rate", (_TURNING,), _ALONG | _ACROSS | _ACCELERATION),
    _Rule("acceleration", (_ACCELERATION, _ALONG), _TURNING),
    _Rule("lateral_acceleration", (_ACCELERATION, _ACROSS), _TURNING),
    _Rule("brake_demand", (_BRAKE, _PRESSURE)),
    _Rule("speed", (_CAR, _SPEED), _WHEEL | _TURNING),
)
"""The first that holds counts. Those of wheels are for names with the place of a wheel, the others for the others."""


@dataclass(frozen=True)
class _Candidate:
    quantity: str
    place: str
    """Of a wheel; empty for a quantity of the car."""
    template: str
    """Name without the place: wheels of one kind share it."""
    rank: int
    """The higher, the surer."""
    signal: ListedSignal


def draft_map(signals: Sequence[ListedSignal], log: Path, vehicle: str, dbc: Path | None) -> tuple[str, list[str]]:
    """Return the text of a map, and the quantities that it names.

    Args:
        signals: those of the log.
        log: the log.
        vehicle: name or path of the vehicle file; empty where it is not known.
        dbc: DBC file of a CAN log.
    """
    candidates = [each for signal in signals for each in _candidates(signal)]
    chosen = {name: each for name in QUANTITIES if (each := _best(name, candidates))}
    chosen = {name: each for name, each in chosen.items() if QUANTITIES[name].needs in ("", *chosen)}
    car = vehicle or "my_car.yaml"
    unknown = "" if vehicle else "   # write one by the car's data sheet; a shipped one shows how"
    lines = [
        f"# Drafted from the names in {log.name}: look it through, then let the doctor judge it.",
        f"vehicle: {car}{unknown}",
    ]
    if dbc is not None and any(each.signal.source == "can" for group in chosen.values() for each in group):
        lines.append(f"can: {{dbc: {dbc.absolute()}}}")
    columns = [each.name for each in signals if each.source == "table"]
    if columns and sum(map(is_time, columns)) != 1:
        lines.append(f"stamp: {_quoted(columns[0])}   # the column of the time, if it is another one")
    lines.append("signals:")
    for name, group in chosen.items():
        lines += _entry(name, group)
    return "\n".join(lines) + "\n", list(chosen)


def _candidates(signal: ListedSignal) -> Iterator[_Candidate]:
    own = _words(signal.name if signal.type else signal.name.rpartition(".")[2])
    place, rest = _place([*(_words(signal.source) if signal.type else ()), *own])
    if _OTHER.intersection(own):
        return
    for rule in _RULES:
        if QUANTITIES[rule.quantity].per_wheel != bool(place) or rule.none.intersection(rest):
            continue
        if all(words.intersection(rest) for words in rule.every):
            rank = sum(len(words.intersection(rest)) for words in rule.every) + bool(_unit(signal, rule.quantity))
            source = signal.source if signal.type else signal.name.rpartition(".")[0]
            yield _Candidate(rule.quantity, place, f"{source} {' '.join(rest)}", rank, signal)
            return


def _words(text: str) -> list[str]:
    return [word.lower() for word in _WORD.findall(text)]


def _place(words: Sequence[str]) -> tuple[str, list[str]]:
    """Return the place of a wheel that words name, and the words without it."""
    for place, spellings in _PLACES.items():
        for word in words:
            if word in spellings:
                return place, [each for each in words if each != word]
        axle, side = place.split("_")
        if axle in words and side in words:
            return place, [each for each in words if each not in _SIDES]
    return "", list(words)


def _unit(signal: ListedSignal, quantity: str) -> str:
    """Return the unit of a signal as a map names it, by its own or by the end of its name; empty where it has none."""
    dimension = QUANTITIES[quantity].dimension
    if signal.unit:
        return unit_named(signal.unit, dimension) or ""
    found = re.search(r"[\[(_ ]\s*([^\[\](_ ]+?)\s*[\])]?$", signal.name)
    return (unit_named(found[1], dimension) or "") if found else ""


def _best(quantity: str, candidates: Sequence[_Candidate]) -> list[_Candidate]:
    """Return the signals of a quantity: of the wheels those that share a name but for the place."""
    groups: defaultdict[str, dict[str, _Candidate]] = defaultdict(dict)
    for each in candidates:
        if each.quantity == quantity:
            groups[each.template].setdefault(each.place, each)
    full = [list(group.values()) for group in groups.values() if not QUANTITIES[quantity].per_wheel or len(group) == 4]
    return max(full, key=lambda group: group[0].rank, default=[])


def _entry(quantity: str, group: Sequence[_Candidate]) -> list[str]:
    first = group[0].signal
    per_wheel = QUANTITIES[quantity].per_wheel
    if first.type:
        source = f"{{topic: {first.source}, type: {first.type}}}"
    else:
        source = (
            first.source
            if per_wheel
            else f"{{{'column' if first.source == 'table' else 'can'}: {_quoted(first.name)}}}"
        )
    unit, si = _unit(first, quantity), next(iter(UNITS[QUANTITIES[quantity].dimension]))
    lines = [f"  {quantity}:", f"    from: {source}"]
    if per_wheel:
        fields = ", ".join(f"{each.place}: {_quoted(each.signal.name)}" for each in group)
        lines.append(f"    fields: {{{fields}}}")
    elif first.type:
        lines.append(f"    field: {first.name}")
    is_stated = bool(first.unit) and first.source == "can"
    if not is_stated:
        lines.append(
            f"    unit: {unit or si}{'' if unit else '   # not stated in the log: the doctor tells whether it is'}"
        )
    return lines


def _quoted(name: str) -> str:
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'

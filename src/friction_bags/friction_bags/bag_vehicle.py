"""The car of a bag: from the command line, else from a note in the bag, else from parameter files."""

from friction_bags.bag_io.bag_reader import BagReader
from friction_parameters.parameter import ParameterError
from friction_runtime.processor import Report
from vehicle_models.vehicle_file import vehicle_choices, vehicle_reference

VEHICLE_NOTE = "vehicle"
"""Key of the note of a bag that names its car: name of a shipped vehicle file, or path of another."""
CAR_OTHERWISE = "that of the bag, or of the parameter files"
"""The car of a command without --vehicle, as vehicle_for chooses it."""


def vehicle_for(reader: BagReader, given: str, by_files: str, report: Report) -> str:
    """Choose the car of a bag; return it as vehicle_reference does.

    Args:
        reader: the bag.
        given: vehicle file on the command line, empty for none.
        by_files: vehicle file in parameter files, empty for none.
        report: log function; called where the note overrides the files.

    Raises:
        ParameterError: no car is named, or there is no such file; the text names those shipped.
    """
    noted = reader.custom_data.get(VEHICLE_NOTE, "")
    chosen = given or noted or by_files
    try:
        note = vehicle_reference(chosen)
    except ParameterError as error:
        if not chosen:
            raise ParameterError(f"{reader.bag} does not name its car: give --vehicle, {vehicle_choices()}") from error
        where = "--vehicle" if given else f"note '{VEHICLE_NOTE}' of {reader.bag}" if noted else "parameter files"
        raise ParameterError(f"{where}: {error}") from error
    if noted and by_files and not given and vehicle_reference(by_files) != note:
        report("warning", f"{reader.bag} is of the car '{noted}'; '{by_files}' of the parameter files needs --vehicle")
    return note

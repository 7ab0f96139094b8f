"""Makes the sample of a recording of TIA Portal's trace beside this file: the layout is that of `src/recording/tia_samples.rs`, with
the XML of a controller's recording around it.

    python3 make_ttrecx.py
"""
import math
import pathlib
import struct
import zipfile

here = pathlib.Path(__file__).parent
count, cycle_ns, start_ns = 50, 1_000_000, 1_752_527_459_096_670_491
position_mm = [100 * math.sin(2 * math.pi * 5 * (k * 1e-3)) for k in range(count)]
current_ma = [1500 if k // 10 % 2 == 0 else -1500 for k in range(count)]
signals = [
    (0, '"Axis".ActualPosition', "LReal", "Double", 14, "mm", struct.pack(f"<{count}d", *position_mm)),
    (1, '"Drive".axis[1].Current', "DInt", "Int32", 9, "mA", struct.pack(f"<{count}i", *current_ma)),
    (5, '"Axis".StatusWord.Enabled', "Bool", "Boolean", 3, "", bytes(k > 3 for k in range(count))),
]


def text(word):
    return bytes([len(word)]) + word.encode()


def numbers(values, kind="I"):
    return struct.pack("<I", len(values)) + struct.pack(f"<{len(values)}{kind}", *values)


samples = text("TSP:1.0") + struct.pack("<BIQIIIIII", 1, 4746399, start_ns, count, count, 0, 0, 0, 0)
samples += numbers([signal[0] for signal in signals]) + numbers([signal[4] for signal in signals])
samples += struct.pack("<I", 1) + text("TSSBL:1.0") + numbers(range(4746149, 4746149 + count))
samples += numbers([start_ns + k * cycle_ns for k in range(count)], "Q") + struct.pack("<I", len(signals))
for signal in signals:
    samples += struct.pack("<I", signal[4]) + text("TSSG:1.0") + struct.pack("<II", 0, count) + signal[6]

records = "".join(
    f"""  <RecordSignal signalId="{place}" isSelected="true" maxVisibleY="100" minVisibleY="-100" displayFormat="Float">
    <ConfigurationSignal signalId="{place}">
      <Name>{name}</Name>
      <Comment />
      <Label>{place}</Label>
      <Visualisation displayColor="255,0,0,255">
        <AddressInformation dataType="{kind}" dataTypeCode="{code}" bitSize="{8 * len(values) // count}" bitOffset="0" displayFormatPreset="Float" iconType="DB" />
      </Visualisation>
    </ConfigurationSignal>
    <Visualisation displayColor="255,0,0,255" />
    {f"<Unit>{unit}</Unit>" if unit else "<Unit />"}
  </RecordSignal>
"""
    for place, name, kind, code, _, unit, values in signals
)
listed = f"""\ufeff<?xml version="1.0" encoding="utf-8"?>
<Signals xmlns:xsd="http://www.w3.org/2001/XMLSchema" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" version="1.0" nextSignalId="6">
{records}</Signals>
"""
general = f"""\ufeff<?xml version="1.0" encoding="utf-8"?>
<General version="1.0">
  <RecordName>Stroke</RecordName>
  <ActualSamples>{count}</ActualSamples>
  <CycleTimeInNs>{cycle_ns}</CycleTimeInNs>
</General>
"""
with zipfile.ZipFile(here / "tia_trace.ttrecx", "w", zipfile.ZIP_DEFLATED) as archive:
    for name, content in [("General", general.encode()), ("Signals", listed.encode()), ("Samples", samples)]:
        archive.writestr(zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0)), content, zipfile.ZIP_DEFLATED)

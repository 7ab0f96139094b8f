"""Makes the binary samples beside this file with the programs that define their layouts: SciPy (MAT v5), h5py (MAT v7.3 is
HDF5 behind a block of 512 bytes) and rosbags (CDR of ROS 2) with the mcap package.

    pip install scipy h5py mcap rosbags
    python3 make.py
"""
import gzip
import pathlib
import struct

import h5py
import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

here = pathlib.Path(__file__).parent
k = np.arange(50)
time = k * 1e-3
position = 0.1 * np.sin(2 * np.pi * 5 * time)
current = np.round(1000 * np.cos(2 * np.pi * 5 * time)).astype(np.int16)
arrays = {"t": time, "pos": position.reshape(-1, 1), "cur": current, "both": np.stack([position, 2 * position], axis=1), "Ts": 1e-3}

savemat(here / "scipy_v5.mat", arrays, do_compression=False)
savemat(here / "scipy_v7.mat", arrays, do_compression=True)

with h5py.File(here / "matlab_v73.mat", "w", userblock_size=512) as file:
    for name, values in arrays.items():
        # MATLAB stores columns first: an n by m array is an m by n data set.
        file.create_dataset(name, data=np.atleast_2d(np.asarray(values)).T if np.ndim(values) == 2 else np.atleast_2d(values))
with open(here / "matlab_v73.mat", "r+b") as file:
    file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 .".ljust(116))
    file.write(b" " * 8 + struct.pack("<H", 0x0200) + b"IM")

store = get_typestore(Stores.ROS2_HUMBLE)
JointState = store.types["sensor_msgs/msg/JointState"]
Header = store.types["std_msgs/msg/Header"]
Float64 = store.types["std_msgs/msg/Float64"]
Time = store.types["builtin_interfaces/msg/Time"]
with open(here / "ros2.mcap", "wb") as stream:
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="rosbags")
    channels = {}
    for topic, kind in [("/joint_states", "sensor_msgs/msg/JointState"), ("/current", "std_msgs/msg/Float64")]:
        text, _ = store.generate_msgdef(kind)
        schema = writer.register_schema(name=kind, encoding="ros2msg", data=text.encode())
        channels[topic] = writer.register_channel(topic=topic, message_encoding="cdr", schema_id=schema)
    start = 1_700_000_000_000_000_000
    for index in k:
        stamp = start + int(index) * 1_000_000
        header = Header(stamp=Time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="base")
        message = JointState(
            header=header, name=["slide", "other"], position=np.array([position[index], 7.0]),
            velocity=np.array([0.5, 0.0]), effort=np.array([]),
        )
        data = bytes(store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
        writer.add_message(channels["/joint_states"], log_time=stamp + 400_000, publish_time=stamp, data=data)
        data = bytes(store.serialize_cdr(Float64(data=float(current[index])), "std_msgs/msg/Float64"))
        writer.add_message(channels["/current"], log_time=stamp, publish_time=stamp, data=data)
    writer.finish()

text = "time_s,position_m\n" + "".join(f"{t!r},{p!r}\n" for t, p in zip(time.tolist(), position.tolist()))
with gzip.GzipFile(here / "log.csv.gz", "wb", mtime=0) as file:
    file.write(text.encode())

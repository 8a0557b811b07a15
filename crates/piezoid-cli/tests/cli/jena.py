"""The client of piezosystem jena, the package nv200, against the simulated controller: python3 jena.py PORT"""

import asyncio
import math
import sys

from nv200.data_recorder import DataRecorder, DataRecorderSource, RecorderAutoStartMode
from nv200.nv200_device import NV200Device
from nv200.shared_types import CtrlMode, DeviceError, ErrorCode, ModulationSource, PidLoopMode, StatusFlags
from nv200.telnet_protocol import TelnetProtocol
from nv200.waveform_generator import WaveformGenerator, WaveformUnit


async def main(port: int) -> None:
    device = NV200Device(TelnetProtocol(host="127.0.0.1", port=port))
    # Without the setup of the Ethernet module, which is a device of its own on another port.
    await device.connect(auto_adjust_comm_params=False)
    assert await device.get_actuator_name() == "PAPER" and await device.has_position_sensor()
    assert await device.get_voltage_range() == (-30, 30)
    low, high = await device.get_position_range()
    assert await device.get_position_unit() == "\u00b5m" and await device.get_voltage_unit() == "V"
    assert await device.is_status_flag_set(StatusFlags.ACTUATOR_CONNECTED)
    assert await device.get_control_mode() == CtrlMode.PID

    # Open loop.
    recorder = DataRecorder(device)
    start = await device.get_current_position()
    await device.move_to_voltage(10)
    await asyncio.sleep(0.3)
    assert await device.get_setpoint() == 10
    assert abs(await recorder.read_single_value_from(DataRecorderSource.PIEZO_VOLTAGE) - 10) < 1e-3
    assert abs(await device.get_current_position() - start) > 1
    try:
        await device.set_setpoint(31)
        raise AssertionError("a voltage outside the range is refused")
    except DeviceError as error:
        assert error.error_code == ErrorCode.ADMISSIBLE_PARAMETER_RANGE_EXCEEDED
    assert await device.get_setpoint() == 10
    await device.set_setpoint(0)

    # Closed loop, to both ends and the middle.
    for target in [high, low, 0.5 * (low + high)]:
        await device.move_to_position(target)
        for _ in range(100):
            await asyncio.sleep(0.05)
            if abs(await device.get_current_position() - target) < 0.005 * (high - low):
                break
        assert abs(await device.get_current_position() - target) < 0.005 * (high - low)
    assert await device.pid.is_closed_loop()
    assert await device.is_status_flag_set(StatusFlags.CLOSED_LOOP_MODE)

    # A move that is recorded, as the example of the recorder does.
    await recorder.set_data_source(0, DataRecorderSource.PIEZO_POSITION)
    await recorder.set_data_source(1, DataRecorderSource.SETPOINT)
    await recorder.set_autostart_mode(RecorderAutoStartMode.START_ON_SET_COMMAND)
    parameters = await recorder.set_recording_duration_ms(500)
    await recorder.start_recording()
    await device.move_to_position(low + 0.6 * (high - low))
    assert await recorder.wait_until_finished()
    position, setpoint = await recorder.read_recorded_data()
    assert position.source == DataRecorderSource.PIEZO_POSITION and len(position.values) == parameters.bufsize == 5000
    assert abs(position.sample_time_ms - 0.1) < 1e-9 and abs(setpoint.values[-1] - (low + 0.6 * (high - low))) < 2e-3
    assert abs(position.values[0] - 0.5 * (low + high)) < 0.02 * (high - low)
    assert abs(position.values[-1] - setpoint.values[-1]) < 0.02 * (high - low)

    # The gains and filters are kept.
    await device.pid.set_pid_gains(kp=0.5, ki=30)
    assert (await device.pid.get_pid_gains()).ki == 30
    await device.pid.set_pcf_gains(position=0.25)
    assert (await device.pid.get_pcf_gains()).position == 0.25
    await device.notch_filter.set_frequency(200)
    await device.setpoint_lpf.set_cutoff(150)
    assert await device.notch_filter.get_frequency() == 200 and await device.setpoint_lpf.get_cutoff() == 150

    # A sine in open loop, in volts, with the recorder started by the generator.
    await device.pid.set_mode(PidLoopMode.OPEN_LOOP)
    await device.set_modulation_source(ModulationSource.SET_CMD)
    await device.set_setpoint(0)
    generator = WaveformGenerator(device)
    sine = generator.generate_sine_wave(freq_hz=5, low_level=-20, high_level=20)
    assert sine.count == 1000 and sine.sample_factor == 4
    await generator.set_waveform(sine, unit=WaveformUnit.VOLTAGE)
    assert await generator.get_loop_settings() == {"start_index": 0, "loop_start_index": 0, "loop_end_index": 999}
    back = await generator.read_waveform_buffer(250, 2, unit=WaveformUnit.VOLTAGE)
    assert all(abs(a - b) < 1e-3 for a, b in zip(back, sine.values[250:252]))
    await recorder.set_data_source(0, DataRecorderSource.PIEZO_VOLTAGE)
    await recorder.set_data_source(1, DataRecorderSource.PIEZO_POSITION)
    await recorder.set_autostart_mode(RecorderAutoStartMode.START_ON_WAVEFORM_GEN_RUN)
    await recorder.set_recording_duration_ms(400)
    await recorder.start_recording()
    await generator.start(cycles=2, start_index=0)
    assert await generator.is_running()
    assert await generator.wait_until_finished() and await recorder.wait_until_finished()
    voltage, position = await recorder.read_recorded_data()
    for k, volts in enumerate(voltage.values[:3990]):
        time_s = 1e-3 * k * voltage.sample_time_ms
        assert abs(volts - 20 * math.sin(2 * math.pi * 5 * time_s)) < 0.2, (k, volts)
    assert max(position.values) - min(position.values) > 1

    # One that is stopped on its way stays there.
    await generator.start(cycles=0, start_index=0)
    await asyncio.sleep(0.3)
    await generator.stop()
    assert not await generator.is_running()
    held = await recorder.read_single_value_from(DataRecorderSource.PIEZO_VOLTAGE)
    await asyncio.sleep(0.2)
    assert await recorder.read_single_value_from(DataRecorderSource.PIEZO_VOLTAGE) == held
    await device.close()


asyncio.run(main(int(sys.argv[1])))
print("all well")

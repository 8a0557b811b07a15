"""pymeasure's classes of a generator and an oscilloscope against the simulated ones: python3 scpi.py PORT OTHER"""

import math
import sys
import time

from pymeasure.instruments.agilent import Agilent33500
from pymeasure.instruments.keysight import KeysightDSOX1102G

END = {"visa_library": "@py", "write_termination": "\n", "read_termination": "\n"}
generator = Agilent33500(f"TCPIP::127.0.0.1::{sys.argv[1]}::SOCKET", **END)
scope = KeysightDSOX1102G(f"TCPIP::127.0.0.1::{sys.argv[2]}::SOCKET", **END)
assert "33500B" in generator.id and "DSO-X" in scope.id
assert generator.shape == "DC" and generator.output and generator.offset == 0
assert not generator.check_errors() and not scope.check_errors()

# One burst of a sine of 20 Hz, 2 V from peak to peak about 0.5 V.
sine = [round(32767 * math.sin(2 * math.pi * k / 200)) for k in range(200)]
generator.offset = 0.5
one = generator.ch_1
one.data_volatile_clear()
one.data_arb("sine", sine, data_format="DAC")
one.arb_file = "sine"
assert one.arb_file == '"SINE"'
one.arb_srate = 4000
one.arb_filter = "OFF"
one.amplitude = 0.01
one.shape = "ARB"
generator.burst_ncycles = 1
generator.burst_mode = "TRIGGERED"
generator.trigger_source = "BUS"
generator.burst_state = True
one.amplitude = 2
assert generator.amplitude == 2 and generator.burst_state and generator.offset == 0.5
assert not generator.check_errors()

scope.timebase_range = 0.1
scope.acquisition_type = "hresolution"
scope.ch1.range = 4
scope.ch1.offset = 0
scope.write(":TRIGger:EDGE:SOURce EXTernal")
scope.single()
time.sleep(0.2)
generator.trigger()
time.sleep(0.3)
assert scope.ask(":OPERegister:CONDition?").strip() == "+0"
scope.waveform_source = "channel1"
scope.waveform_points_mode = "raw"
scope.waveform_format = "ascii"
scope.write(":WAVeform:POINts 8000000")
preamble = scope.waveform_preamble
assert preamble["type"] == "HRES" and preamble["points"] == 2000 and preamble["xincrement"] == 5e-5
data = scope.waveform_data
assert len(data) == 2000 and not scope.check_errors()
# The monitor has a tenth of the voltage behind the amplifier, whose gain is 4.
for k, volts in enumerate(data):
    t = preamble["xorigin"] + k * preamble["xincrement"]
    wave = math.sin(2 * math.pi * 20 * t) if 0 <= t < 0.05 else 0
    assert abs(volts - 0.4 * (0.5 + wave)) < 0.02, (t, volts)

# What it does not know is in the queue.
generator.write("SOUR1:PULS:WIDT 1")
assert generator.check_errors()[0][0] == -113
generator.burst_state = False
generator.shape = "DC"
assert generator.offset == 0.5 and not generator.check_errors()
print("all well")

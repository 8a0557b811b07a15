"""PI's own client against the simulated controller: python3 instrument.py PORT"""

import sys
import time

import numpy as np
from pipython import GCSDevice, datarectools, pitools
from pipython.pidevice.gcserror import GCSError
from pipython.pidevice.interfaces.pisocket import PISocket

with PISocket("127.0.0.1", int(sys.argv[1])) as gateway:
    device = GCSDevice(gateway=gateway)
    assert "simulated" in device.qIDN() and device.axes == ["1"]
    assert device.qSPA(1, 0x0E000200)[1][0x0E000200] == 5e-5
    assert (device.qVMI(1)[1], device.qVMA(1)[1]) == (-30.0, 30.0)

    # Closed loop.
    device.SVO("1", 1)
    device.MOV("1", 300)
    pitools.waitontarget(device)
    assert abs(device.qPOS("1")["1"] - 300) < 5
    assert device.IsControllerReady() and not any(device.IsMoving().values())

    # A sine in open loop, recorded.
    device.SVO("1", 0)
    device.WAV_SIN_P(
        table=1, firstpoint=0, numpoints=500, append="X", center=250, amplitude=20, offset=-10, seglength=500
    )
    device.WSL(1, 1)
    device.WGC(1, 2)
    device.WTR(1, 10, 0)
    recorder = datarectools.Datarecorder(device)
    assert recorder.maxnumvalues == 32768
    recorder.options, recorder.sources, recorder.trigsources = [16, 2], ["1", "1"], 0
    recorder.samplerate, recorder.numvalues = 10, 1000
    recorder.arm()
    device.WGO(1, 1)
    while any(device.IsGeneratorRunning().values()):
        time.sleep(0.05)
    header, data = recorder.getdata()
    voltage, position = np.array(data)
    assert header["SAMPLE_TIME"] == 5e-4 and header["NDATA"] == 1000
    assert abs(voltage - -10 * np.cos(2 * np.pi * np.arange(1000) / 500)).max() < 1e-5
    assert np.corrcoef(voltage, position)[0, 1] > 0.95

    # Points are written in pieces, and read back.
    points = [0.25 * k for k in range(25)]
    pitools.writewavepoints(device, 2, points, 10)
    device.qGWD(2, 1, 25)
    while device.bufstate is not True:
        time.sleep(0.01)
    assert device.bufdata[0] == points

    try:
        device.MOV("1", 1)
        raise AssertionError("a move in open loop is refused")
    except GCSError as error:
        assert error == 5
    device.StopAll(noraise=True)
    assert device.qERR() == 0
print("all well")

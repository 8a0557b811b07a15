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

    # Started as the samples of PIPython do, then to both ends and the middle.
    assert device.devname == "E-727" and device.HasHLT() and not device.HasqFRF()
    pitools.startup(device, stages=None, refmodes=None)
    pitools.waitontarget(device)
    assert device.qSVO("1")["1"] and device.qCST()["1"] == "PAPER"
    assert device.IsControllerReady() and not any(device.IsMoving().values())
    ends = device.qTMN("1")["1"], device.qTMX("1")["1"]
    for target in [ends[0], ends[1], sum(ends) / 2, ends[1]]:
        begin = time.monotonic()
        pitools.moveandwait(device, "1", target, timeout=20)
        assert time.monotonic() - begin > 0.1, "a move takes time"
        assert abs(device.qPOS("1")["1"] - target) < 0.002 * (ends[1] - ends[0])
        assert device.qONT("1")["1"] and not device.qOVF("1")["1"]
    device.VEL("1", 500)
    assert device.qVEL("1")["1"] == 500
    device.MOV("1", 0)
    assert device.IsMoving("1")["1"]
    pitools.waitonready(device)
    # 50 um from the end, which noise and overshoot do not reach.
    time.sleep(0.1)
    device.StopAll(noraise=True)
    assert ends[0] < device.qPOS("1")["1"] < ends[1]
    assert device.qERR() == 0
    pitools.moveandwait(device, "1", 0, timeout=20)

    # A move that is recorded, as the sample of the recorder does.
    recorder = datarectools.Datarecorder(device)
    recorder.numvalues, recorder.samplefreq = 1000, 1000
    recorder.options = 1, 2
    recorder.sources, recorder.trigsources = "1", 1
    recorder.arm()
    assert device.qDRT(1)[1][0] == 1
    device.MVR("1", 200)
    header, (commanded, actual) = recorder.getdata(timeout=20)
    assert header["NDATA"] == 1000 and abs(header["SAMPLE_TIME"] - 1e-3) < 1e-9
    # 200 um at 500 um/s.
    assert commanded[0] < 2 and commanded[-1] == 200 and abs(commanded[200] - 100) < 2
    assert abs(actual[0]) < 5 and abs(actual[-1] - 200) < 5 and abs(actual[200] - 100) < 20

    # Parameters, and questions about waves.
    device.CCL(1, "advanced")
    device.SPA("1", 0x07000900, 2.5)
    assert device.qSPA("1", 0x07000900)["1"][0x07000900] == 2.5 and device.qCCL() == 1
    device.CCL(0)
    device.WAV_LIN(
        table=3, firstpoint=0, numpoints=100, append="X", speedupdown=10, amplitude=20, offset=-10, seglength=100
    )
    device.WAV_RAMP(
        table=4, firstpoint=0, numpoints=100, append="X", center=50, speedupdown=10, amplitude=20, offset=-10,
        seglength=100,
    )
    device.WSL(1, 3)
    assert device.qWAV(3, 1)[3][1] == 100 and device.qWSL(1)[1] == 3
    device.WGC(1, 5)
    device.WOS(1, 2.5)
    assert device.qWGC(1)[1] == 5 and device.qWOS(1)[1] == 2.5 and not device.qWGO(1)[1]
    device.WOS(1, 0)
    assert device.qTNR() == 4 and device.qTWG() == 1 and device.qTPC() == 1

    # A sine in open loop, recorded.
    device.SVO("1", 0)
    device.ATZ("1", "NaN")
    assert device.qATZ("1")["1"]
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

"""A rigid body that Basilisk's torque rods turn, by the law of `maneuvers.drives`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mgeo_attitude._typing import Bools, Floats
from mgeo_attitude.maneuvers import CoilDrive, decode, maneuver_steps


@dataclass(frozen=True)
class Coiled:
    """What coils of a satellite are asked for.

    Attributes
    ----------
    drive : CoilDrive
    rates : array, shape (n, 3)
        Body rate that is asked for in each step [rad/s].
    begins : array of bool, shape (n,)
        Whether a maneuver begins with the step.
    """

    drive: CoilDrive
    rates: Floats
    begins: Bools

    @classmethod
    def of(cls, drive: CoilDrive, design: Floats, step: float, n_steps: int) -> Coiled:
        """Of a design, shape (4 m,), on n steps."""
        rates, durations = decode(design)
        starts, _ = maneuver_steps(durations, step)
        steps = np.arange(n_steps)
        which = np.searchsorted(starts[0], steps, side="right") - 1
        return cls(drive, rates[0, which], np.isin(steps, starts[0]))

    @property
    def inertia(self) -> Floats:
        """J, shape (3, 3) [kg m²]."""
        return self.drive.inertia


def coil_control(
    coiled: Coiled,
    satellite: Any,
    field: Any,
    imu: Any,
    corrected: Callable[[Floats], Floats],
    bias: Floats,
    timing: tuple[int, int, Floats],
) -> tuple[Any, Sequence[Any]]:
    """Basilisk's torque rods along the body axes, and what commands them.

    Parameters
    ----------
    corrected : function
        Takes what is believed of the gyro out of a rate.
    bias : array, shape (n, 3)
        Of the gyro in each step of the simulation [rad/s].
    timing : int, int, array of shape (3,)
        Nanoseconds of such a step, how many there are in one of the filter, and the body rate at
        the start [rad/s].
    """
    from Basilisk.architecture import messaging, sysModel
    from Basilisk.simulation import MtbEffector
    from Basilisk.utilities import RigidBodyKinematics

    drive, (nanoseconds, parts, initial_rate) = coiled.drive, timing

    class Controller(sysModel.SysModel):
        """The cross-product law, by the gyro and the true field; it also lets the bias drift."""

        def __init__(self) -> None:
            super().__init__()
            self.ModelTag, self.dipoles = "coils", messaging.MTBCmdMsg()
            self.off = True
            self.kept: tuple[Any, ...] = ()

        def Reset(self, now: int) -> None:
            self.off = True
            self.dipoles.write(messaging.MTBCmdMsgPayload(), now, self.moduleID)

        def UpdateState(self, now: int) -> None:
            k = round(now / nanoseconds)
            imu.senRotBias = bias[min(k, len(bias) - 1)]  # until the next instant
            if k % parts or k // parts >= len(coiled.rates):
                return
            rate = initial_rate
            if k > 0:
                rate = corrected(np.array(imu.sensorOutMsg.read().AngVelPlatform))
            attitude = RigidBodyKinematics.MRP2C(satellite.scStateOutMsg.read().sigma_BN)
            b = attitude @ np.array(field.envOutMsgs[0].read().magField_N)
            error = rate - coiled.rates[k // parts]
            self.off = self.off and not coiled.begins[k // parts]
            self.off = self.off or bool(np.linalg.norm(error) <= drive.near)
            torque = np.cross(rate, drive.inertia @ rate) - drive.inertia @ error / drive.response
            dipole = np.cross(b, torque) / (b @ b)
            dipole /= max(1.0, float(np.abs(dipole / drive.max_dipole).max()))
            command = messaging.MTBCmdMsgPayload()
            command.mtbDipoleCmds = (dipole * (not self.off) + drive.residual_dipole).tolist()
            self.dipoles.write(command, now, self.moduleID)

    controller, rods = Controller(), MtbEffector.MtbEffector()
    rods.ModelTag = "torque rods"
    array = messaging.MTBArrayConfigMsgPayload()
    array.numMTB, array.GtMatrix_B = 3, np.eye(3).ravel().tolist()
    array.maxMtbDipoles = (drive.max_dipole + np.abs(drive.residual_dipole)).tolist()
    parameters = messaging.MTBArrayConfigMsg().write(array)
    rods.mtbParamsInMsg.subscribeTo(parameters)
    rods.mtbCmdInMsg.subscribeTo(controller.dipoles)
    rods.magInMsg.subscribeTo(field.envOutMsgs[0])
    satellite.addDynamicEffector(rods)
    controller.kept = (parameters,)  # subscribers only point to messages
    return rods, (controller,)

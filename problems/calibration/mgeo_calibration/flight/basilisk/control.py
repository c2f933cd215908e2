"""Guidance and control: the plan's rates are followed by what the gyro says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback, rwMotorTorque
from Basilisk.simulation import MtbEffector, reactionWheelStateEffector
from Basilisk.utilities import RigidBodyKinematics, simIncludeRW
from mgeo_attitude._typing import Floats
from mgeo_attitude.maneuvers.motion import Motion
from scipy.spatial.transform import Rotation

from mgeo_calibration.flight.basilisk.vehicle import Coiled, Vehicle

#: Speed at which a wheel stores its greatest momentum [rpm]; it says how heavy the wheel is.
WHEEL_SPEED = 6000.0

#: Inertia of a wheel without limit of momentum, as a fraction of the satellite's least.
WHEEL_SHARE = 1e-3

DAMPING = 0.7


@dataclass(frozen=True)
class Reference:
    """Where the plan has the satellite at n + 1 instants, as Basilisk takes it.

    Attributes
    ----------
    attitude : array, shape (n + 1, 3)
        Modified Rodrigues parameters.
    rate, acceleration : array, shape (n + 1, 3)
        Of the body [rad/s], [rad/s²], along the axes of GCRS.
    """

    attitude: Floats
    rate: Floats
    acceleration: Floats

    @classmethod
    def of(cls, motion: Motion, initial_rate: Floats, step: float, parts: int) -> Reference:
        """From steps of constant rate [s], cut into parts, and the rate before them [rad/s].

        Where rates change the rate is the mean of both steps': what a straight ramp has there.
        """
        h, rates = step / parts, np.repeat(motion.rates, parts, axis=0)
        turns = np.tile(h * np.arange(parts), len(motion.rates))[:, None] * rates
        within = Rotation.from_rotvec(-turns).as_matrix()
        to_body = np.concatenate(
            [within @ np.repeat(motion.attitude[:-1], parts, axis=0), motion.attitude[-1:]]
        )
        before, after = np.vstack([initial_rate, rates]), np.vstack([rates, rates[-1:]])
        mean, change = 0.5 * (before + after), np.vstack([after[1:], after[-1:]]) - before
        return cls(
            Rotation.from_matrix(to_body).inv().as_mrp(),
            np.einsum("kji,kj->ki", to_body, mean),
            np.einsum("kji,kj->ki", to_body, 0.5 * change / h),
        )


class Guidance(sysModel.SysModel):
    """Navigation by the gyro alone, and the reference; it also lets the gyro's bias drift.

    Attitude and rate are believed at the start as the plan has them, and the attitude is turned by
    what the gyro measures, without the errors that a calibration has found: of what is left, and of
    the error of the attitude, the satellite does not know.
    """

    def __init__(
        self,
        imu: Any,
        reference: Reference,
        initial_rate: Floats,
        corrected: Callable[[Floats], Floats],
        bias: Floats,
        nanoseconds: int,
    ) -> None:
        super().__init__()
        self.ModelTag = "guidance"
        self.navigation, self.wanted = messaging.NavAttMsg(), messaging.AttRefMsg()
        self._imu, self._reference, self._bias = imu, reference, bias
        self._nanoseconds = nanoseconds
        self._initial_rate, self._corrected = initial_rate, corrected
        self._attitude = reference.attitude[0]
        self.kept: tuple[Any, ...] = ()

    def Reset(self, nanoseconds: int) -> None:
        self._attitude = self._reference.attitude[0]
        self._write(nanoseconds, self._initial_rate)

    def UpdateState(self, nanoseconds: int) -> None:
        if nanoseconds == 0:  # nothing is measured yet
            self._write(nanoseconds, self._initial_rate)
            return
        measured = self._imu.sensorOutMsg.read()
        step = 1e-9 * self._nanoseconds
        rate = self._corrected(np.array(measured.DRFramePlatform) / step)
        turn = Rotation.from_rotvec(rate * step).as_mrp()
        self._attitude = RigidBodyKinematics.addMRP(self._attitude, turn)
        self._write(nanoseconds, self._corrected(np.array(measured.AngVelPlatform)))

    def _write(self, nanoseconds: int, rate: Any) -> None:
        k = round(nanoseconds / self._nanoseconds)
        self._imu.senRotBias = self._bias[min(k, len(self._bias) - 1)]  # until the next instant
        now, wanted = messaging.NavAttMsgPayload(), messaging.AttRefMsgPayload()
        now.sigma_BN, now.omega_BN_B = self._attitude, rate
        wanted.sigma_RN = self._reference.attitude[k]
        wanted.omega_RN_N = self._reference.rate[k]
        wanted.domega_RN_N = self._reference.acceleration[k]
        self.navigation.write(now, nanoseconds, self.moduleID)
        self.wanted.write(wanted, nanoseconds, self.moduleID)


def reaction_wheels(vehicle: Vehicle, satellite: Any, rate: Floats) -> tuple[Any, Any]:
    """Basilisk's wheels, fixed to a satellite that turns, and the message of what they are.

    They spin as `Vehicle.momentum` says. One at the limit of its momentum cannot be sped up.
    """
    factory, wheels = simIncludeRW.rwFactory(), vehicle.wheels
    rpm = 2.0 * np.pi / 60.0
    speed = WHEEL_SPEED * rpm
    limits: dict[str, Any] = {"Js": WHEEL_SHARE * min(wheels.inertia), "useMaxTorque": False}
    if wheels.max_momentum is not None:
        limits |= {"Js": wheels.max_momentum / speed, "Omega_max": WHEEL_SPEED}
    if wheels.max_torque is not None:
        limits |= {"useMaxTorque": True, "u_max": wheels.max_torque}
    for axis, momentum in zip(wheels.spin_axes(), vehicle.momentum(rate), strict=True):
        spin = float(momentum / limits["Js"] / rpm)
        factory.create("custom", axis.tolist(), Omega=spin, **limits)
    effector = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("wheels", effector, satellite)
    return effector, factory.getConfigMessage()


def control_loop(
    vehicle: Vehicle, guidance: Guidance, effector: Any, configuration: Any
) -> Sequence[Any]:
    """Basilisk's tracking error, feedback and sharing of torque, in the order they are run in."""
    inertia = vehicle.wheels.matrix()
    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(guidance.navigation)
    error.attRefInMsg.subscribeTo(guidance.wanted)
    feedback, largest = mrpFeedback.mrpFeedback(), float(np.linalg.eigvalsh(inertia)[-1])
    feedback.K = 4.0 * largest * vehicle.bandwidth**2  # a quarter of the angle is the parameter
    feedback.P = 2.0 * DAMPING * largest * vehicle.bandwidth
    feedback.Ki = -1.0  # none
    body = messaging.VehicleConfigMsgPayload()
    body.ISCPntB_B = inertia.ravel().tolist()
    satellite = messaging.VehicleConfigMsg().write(body)
    feedback.guidInMsg.subscribeTo(error.attGuidOutMsg)
    feedback.vehConfigInMsg.subscribeTo(satellite)
    feedback.rwParamsInMsg.subscribeTo(configuration)
    feedback.rwSpeedsInMsg.subscribeTo(effector.rwSpeedOutMsg)
    motors = rwMotorTorque.rwMotorTorque()
    motors.controlAxes_B = np.eye(3).ravel().tolist()
    motors.vehControlInMsg.subscribeTo(feedback.cmdTorqueOutMsg)
    motors.rwParamsInMsg.subscribeTo(configuration)
    effector.rwMotorCmdInMsg.subscribeTo(motors.rwMotorTorqueOutMsg)
    guidance.kept = (configuration, satellite)  # subscribers only point to messages
    return error, feedback, motors


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

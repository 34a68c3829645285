"""The settings of the odometer."""

from pydantic import Field

from dock_gateway.settings import ExtensionSettings


class OdometerSettings(ExtensionSettings):
    """When a robot is due for service."""

    odometer_service_km: float = Field(1000.0, gt=0, description="Kilometres after which a robot is due for service.")

"""Path loss jump: something comes between the aircraft, or goes, and every range is wrong from then on."""

from rss_gym.encounters.family import Complication, Family, degrees

PATH_LOSS_JUMP = Family(
    summary="the path loss factor jumps by 0.15-0.4 within 5 s of the entry into the zone",
    weight=0.0,
    crossing_rad=degrees(30, 180),
    conflict_share=0.42,
    complication=Complication(path_loss_jump=(0.15, 0.4)),
)

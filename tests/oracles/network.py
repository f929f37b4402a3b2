"""PC-NBV as a textbook has it: one cloud at a time, real points only, edges laid into memory whole, features repeated and joined.

It takes the parameters of a fast network by name and shares no layer with it.
"""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn.functional import linear

from viewgain.rigs import Target, poses, rig


def nearest_by_hand(features: Tensor, count: int, points: Tensor, scale: float) -> Tensor:
    """Return (n, min(k, n - 1)) the nearest other points of (n, C) features, each distance from its own subtraction.

    Of equally near ones that count as nearer which lie back along (0.61, 0.41, 0.73), by 1e-4 ``scale`` per unit.
    """
    lean = 1e-4 * scale * (points @ torch.tensor([0.61, 0.41, 0.73], dtype=points.dtype))
    apart = (features[:, None] - features[None]).square().sum(-1) + lean
    rows = [[j for j in torch.argsort(row).tolist() if j != i][:count] for i, row in enumerate(apart)]
    return torch.tensor(rows if len(features) > 1 else [[0]])


def dense_edge_conv(block: nn.Module, features: Tensor, neighbours: Tensor) -> Tensor:
    """Return (n, C + 3 growth) from (n, C) by edges (n, k, 2C)."""
    centre = features[:, None].expand(-1, neighbours.shape[1], -1)
    edges = torch.cat((centre, features[neighbours] - centre), dim=-1)
    layers = torch.cat((torch.relu(block.first(edges)), centre), dim=-1)
    layers = torch.cat((torch.relu(block.middle(layers)), layers), dim=-1)
    layers = torch.cat((block.last(layers), layers), dim=-1)
    return layers.max(dim=1).values


def on_joined(layer: nn.Linear, points: Tensor, cloud: Tensor) -> Tensor:
    """Return (n, out) of a layer on points with the cloud's feature repeated beside each."""
    return linear(torch.cat((points, cloud.expand(len(points), -1)), dim=-1), layer.weight, layer.bias)


def pc_nbv(network: nn.Module, points: Tensor, view_state: Tensor | None) -> Tensor:
    """Return the (outputs,) of one cloud (n, 3), view state (V,) or None."""
    extraction, count = network.features, network.settings.neighbours
    features = extraction.lift(points)
    for index, block in enumerate(extraction.blocks):
        narrow = features if index == 0 else torch.relu(extraction.narrow[index - 1](features))
        spread = (narrow - narrow.mean(dim=0)).detach().square().sum(-1).mean().item()
        neighbours = nearest_by_hand(narrow.detach(), count, points, spread)
        features = torch.cat((dense_edge_conv(block, narrow, neighbours), features), dim=-1)
    cloud = features.max(dim=0, keepdim=True).values
    cloud = cloud if view_state is None else torch.cat((cloud, view_state[None]), dim=-1)
    unit = network.attention
    query, key, value = (torch.relu(on_joined(each, features, cloud)) for each in (unit.query, unit.key, unit.value))
    joined = torch.cat((features, cloud.expand(len(features), -1)), dim=-1)
    attended = unit.gamma * (torch.softmax(query @ key.T, dim=-1) @ value) + joined
    return network.head(network.shared(attended).max(dim=0).values)


def set_abstraction(block: nn.Module, places: Tensor, features: Tensor) -> tuple[Tensor, Tensor]:
    """Return (M, 3) and (M, out) from (n, 3) and (n, C): a layer on (x_i, x_j), the maximum over edges, relu, a layer."""
    joined = torch.cat((features, places), dim=-1)
    weight = torch.cat((block.own.weight, block.other.weight), dim=1)
    chosen = [i * len(places) // block.centres for i in range(block.centres)]
    lean = 1e-5 * (places @ torch.tensor([0.61, 0.41, 0.73], dtype=places.dtype))
    mixed = []
    for i in chosen:
        apart = (places - places[i]).square().sum(-1) + lean
        near = torch.argsort(apart, stable=True)[: block.neighbours]
        edges = torch.cat((joined[i].expand(len(near), -1), joined[near]), dim=-1)
        mixed.append(torch.relu(linear(edges, weight, block.own.bias)).max(dim=0).values)
    return places[chosen], torch.relu(block.after(torch.stack(mixed)))


def ask(block: nn.Module, queries: Tensor, points: Tensor) -> Tensor:
    """Return (V, Q) of attention, head by head and view by view."""
    size = queries.shape[-1] // 4
    keys, values = block.key(points), block.value(points)
    found = [
        torch.cat(
            [
                torch.softmax(keys[:, part] @ query[part] / size**0.5, dim=0) @ values[:, part]
                for part in (slice(head * size, (head + 1) * size) for head in range(4))
            ]
        )
        for query in queries
    ]
    return block.out(torch.stack(found))


def compact(network: nn.Module, points: Tensor, view_state: Tensor | None) -> Tensor:
    """Return the (outputs,) of one cloud (n, 3), view state (V,) or None."""
    points = points[torch.argsort(points @ torch.tensor([0.61, 0.41, 0.73], dtype=points.dtype))]
    lifted = network.hierarchy.lift(points)
    near, fine = set_abstraction(network.hierarchy.fine, points, lifted)
    far, coarse = set_abstraction(network.hierarchy.coarse, near, fine)
    seen = None if network.look is None else look(network.look, fine, near, network.settings.rig)
    fine, coarse = torch.cat((fine, near), dim=-1), torch.cat((coarse, far), dim=-1)
    greatest = torch.relu(network.wide(coarse).max(dim=0).values)
    cloud = torch.relu(network.cloud(torch.cat((greatest, sum(lifted) / len(lifted)))))
    if view_state is not None:
        answers = network.head(view_queries(network.queries, cloud, coarse, fine, seen, view_state))
        return answers.T.flatten() if answers.shape[1] > 1 else answers[:, 0]
    presence = network.guess.presence(view_queries(network.guess.queries, cloud, coarse, fine, seen, None))[:, 0]
    if network.guess.even is not None:
        presence = presence + 20 * network.guess.even(evenness(points, network.settings.rig))[:, 0]
    chances = torch.softmax(presence, dim=0)
    answers = network.head(view_queries(network.queries, cloud, coarse, fine, seen, chances))
    answers = sum(chance * torch.roll(answers, -view, dims=0) for view, chance in enumerate(chances))
    return answers.T.flatten() if answers.shape[1] > 1 else answers[:, 0]


def view_queries(
    asks: nn.Module, cloud: Tensor, coarse: Tensor, fine: Tensor, seen: list[Tensor] | None, view_state: Tensor | None
) -> Tensor:
    """Return (V, channels) what the views learn, one after the other."""
    views = []
    for k, query in enumerate(asks.view):
        told = cloud if view_state is None else torch.cat((cloud, view_state, view_state[k : k + 1]))
        views.append(query + asks.whole(told) + (0 if seen is None else seen[k]))
    found = torch.stack(views)
    found = found + ask(asks.inquiry.coarse, found, coarse)
    found = found + asks.inquiry.think(found)
    return torch.relu(found + ask(asks.inquiry.fine, found, fine))


def look(block: nn.Module, features: Tensor, points: Tensor, name: str) -> list[Tensor]:
    """Return what each view of a rig sees, point by point: a point is turned as the world is for a camera there."""
    seen = []
    for station in poses(rig(name), Target.at(np.zeros(3)), distance=2.0):
        to_camera = torch.from_numpy(np.linalg.inv(station)[:3, :3])
        each = [torch.relu(block.what(f) + block.where(to_camera @ p)) for f, p in zip(features, points, strict=True)]
        seen.append(block.after(torch.stack(each).max(dim=0).values))
    return seen


def evenness(points: Tensor, name: str) -> Tensor:
    """Return (V, 4) statistics of the spacing of points in the image of each view of a rig, less their mean over the views."""
    rows = []
    for station in poses(rig(name), Target.at(np.zeros(3)), distance=1.0):
        seen = np.c_[points.detach().numpy(), np.ones(len(points))] @ np.linalg.inv(station).T
        each = spacings(seen[:, :2] / seen[:, 2:3])
        here = each.mean(axis=1)
        rows.append([each.mean(), here.std(), np.abs(here - here.mean()).mean(), each.std()])
    return torch.tensor(np.array(rows) - np.mean(rows, axis=0), dtype=points.dtype)


def spacings(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (128, 7) logarithms: of the distance from every so manieth of (n, 2) places to each group of which it is none."""
    found = np.zeros((128, 7))
    for row in range(128):
        asked = row * len(image) // 128
        for k in range(1, 8):
            of_group = range((asked + k) % 8, len(image), 8)
            apart = min((float(np.linalg.norm(image[asked] - image[n])) for n in of_group), default=np.inf)
            found[row, k - 1] = np.log(np.clip(apart, 2e-3, 1.0))
    return found

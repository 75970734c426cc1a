// Metallic-roughness reflection: a GGX microfacet surface over a diffuse base. Directions point away from the
// surface and are in its frame, z along the shading normal.
// Source: Walter et al. 2007 (GGX); Heitz, JCGT 7(4), 2018 (visible normals); Kelemen and Szirmay-Kalos 2001
// (a diffuse base that takes what the coat leaves, so that no direction reflects more than it receives).

// Below this alpha, f32 no longer resolves the highlight.
const MIN_ALPHA: f32 = 1e-3;
// Reflectance of glass-like surfaces at grazing incidence over that at normal incidence: 1 / 0.04.
const GRAZING: f32 = 25.0;
// Mean over the hemisphere of (1 - cos)^5, cosine-weighted: 1 / 21.
const MEAN_SCHLICK: f32 = 0.047619;

struct Bsdf {
    diffuse: vec3f,
    f0: vec3f,
    // Reflectance at grazing incidence.
    f90: f32,
    // That of the dielectric coat alone.
    coat_f0: f32,
    alpha: f32,
    // Probability of sampling the microfacets.
    choose_specular: f32,
}

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

fn schlick(cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    let x2 = x * x;
    return x2 * x2 * x;
}

fn make_bsdf(surface: Surface, out_cosine: f32) -> Bsdf {
    var bsdf: Bsdf;
    bsdf.diffuse = diffuse_color(surface);
    bsdf.f0 = specular_color(surface);
    bsdf.f90 = mix(surface.specular, 1.0, surface.metallic);
    bsdf.coat_f0 = 0.04 * surface.specular;
    bsdf.alpha = max(surface.roughness * surface.roughness, MIN_ALPHA);
    let specular = luminance(mix(bsdf.f0, vec3f(bsdf.f90), schlick(out_cosine)));
    let diffuse = luminance(bsdf.diffuse);
    bsdf.choose_specular = 0.0;
    if specular > 0.0 {
        // At least a tenth of either: a highlight that is rarely sampled is a firefly.
        bsdf.choose_specular = select(1.0, clamp(specular / (specular + diffuse), 0.1, 0.9), diffuse > 0.0);
    }
    return bsdf;
}

// Smith's Lambda for GGX.
fn smith(alpha: f32, v: vec3f) -> f32 {
    let tangent2 = dot(v.xy, v.xy) / max(v.z * v.z, 1e-12);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tangent2) - 1.0);
}

// Reflectance of the lobes times the cosine of the direction that light comes from.
struct Reflected {
    diffuse: vec3f,
    specular: vec3f,
    // Density of sampling that direction, by either lobe.
    pdf: f32,
}

fn evaluate_bsdf(bsdf: Bsdf, out: vec3f, into: vec3f) -> Reflected {
    var reflected = Reflected(vec3f(0.0), vec3f(0.0), 0.0);
    if into.z <= 0.0 || out.z <= 0.0 {
        return reflected;
    }
    let left_over = (1.0 - coat(bsdf, out.z)) * (1.0 - coat(bsdf, into.z)) / (1.0 - coat_mean(bsdf));
    reflected.diffuse = bsdf.diffuse * (left_over * into.z / PI);
    reflected.pdf = (1.0 - bsdf.choose_specular) * into.z / PI;
    if bsdf.choose_specular > 0.0 {
        let h = normalize(out + into);
        // In the frame of the surface the small differences that a narrow highlight is made of stay exact.
        let scaled = vec3f(h.xy / bsdf.alpha, h.z);
        let length2 = dot(scaled, scaled);
        let distribution = 1.0 / (PI * bsdf.alpha * bsdf.alpha * length2 * length2);
        let lambda_out = smith(bsdf.alpha, out);
        let fresnel = mix(bsdf.f0, vec3f(bsdf.f90), schlick(dot(out, h)));
        let visible = distribution / (4.0 * out.z);
        reflected.specular = fresnel * (visible / (1.0 + lambda_out + smith(bsdf.alpha, into)));
        reflected.pdf += bsdf.choose_specular * visible / (1.0 + lambda_out);
    }
    return reflected;
}

fn reflectance(reflected: Reflected) -> vec3f {
    return reflected.diffuse + reflected.specular;
}

// What the coat reflects, and so keeps from the base.
fn coat(bsdf: Bsdf, cosine: f32) -> f32 {
    return mix(bsdf.coat_f0, bsdf.coat_f0 * GRAZING, schlick(cosine));
}

fn coat_mean(bsdf: Bsdf) -> f32 {
    return mix(bsdf.coat_f0, bsdf.coat_f0 * GRAZING, MEAN_SCHLICK);
}

// A direction to go on in; its density is `evaluate_bsdf`'s.
struct Bounce {
    into: vec3f,
    // The lobe that it was drawn from.
    is_specular: bool,
}

fn sample_bsdf(bsdf: Bsdf, out: vec3f) -> Bounce {
    let choice = random();
    let u = random2();
    if choice < bsdf.choose_specular {
        return Bounce(sample_specular(bsdf, out, u), true);
    }
    let angle = 2.0 * PI * u.y;
    let r = sqrt(u.x);
    return Bounce(vec3f(r * cos(angle), r * sin(angle), sqrt(max(1.0 - u.x, 0.0))), false);
}

// Heitz 2018, listing 1.
fn sample_specular(bsdf: Bsdf, out: vec3f, u: vec2f) -> vec3f {
    let angle = 2.0 * PI * u.y;
    let v = normalize(vec3f(out.xy * bsdf.alpha, out.z));
    let across2 = dot(v.xy, v.xy);
    var t1 = vec3f(1.0, 0.0, 0.0);
    if across2 > 1e-12 {
        t1 = vec3f(-v.y, v.x, 0.0) * inverseSqrt(across2);
    }
    let t2 = cross(v, t1);
    let r = sqrt(u.x);
    let p1 = r * cos(angle);
    let s = 0.5 * (1.0 + v.z);
    let p2 = mix(sqrt(max(1.0 - p1 * p1, 0.0)), r * sin(angle), s);
    let n = t1 * p1 + t2 * p2 + v * sqrt(max(1.0 - p1 * p1 - p2 * p2, 0.0));
    let h = normalize(vec3f(n.xy * bsdf.alpha, max(n.z, 1e-6)));
    return reflect(-out, h);
}

// Columns: tangent, bitangent, normal. Source: Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
fn basis(n: vec3f) -> mat3x3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    return mat3x3f(vec3f(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3f(b, sign + n.y * n.y * a, -n.y), n);
}

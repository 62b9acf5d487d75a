//! Creates a session of a tumbling spacecraft, goes to a step, and streams samples:
//!
//!     cargo run [HOST:PORT]
#[allow(dead_code)] // not every message is used here
mod pb {
    tonic::include_proto!("stiefel.v1");
}
use pb::simulation_service_client::SimulationServiceClient;

/// Prints the k-th quaternion of a tensor of doubles.
fn show(step: i64, tensor: &pb::Tensor, k: usize) {
    let numbers = tensor.data[32 * k..32 * k + 32].chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    println!("step {step}: {}", numbers.map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" "));
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn std::error::Error>> {
    let address = std::env::args().nth(1).unwrap_or("127.0.0.1:50551".into());
    let channel = tonic::transport::Endpoint::new(format!("http://{address}"))?.connect().await?;
    let mut client = SimulationServiceClient::new(channel);
    let (session_id, fields) = (uuid::Uuid::new_v4().to_string(), vec!["quaternion".to_string()]);

    let body = pb::Body {
        moments: vec![1200.0, 900.0, 500.0],
        attitude: vec![0.9238795325112867, 0.0, 0.3826834323650898, 0.0],
        angular_velocity: vec![0.002, 0.06, 0.001],
        ..Default::default()
    };
    let scene = pb::Scene { system: "rigid_body".into(), body: Some(body), step: Some(0.5), ..Default::default() };
    let create = pb::CreateSessionRequest { session_id: session_id.clone(), scene: Some(scene), ..Default::default() };
    client.create_session(create).await?;

    let step = pb::StepRequest { session_id: session_id.clone(), to: 100, fields: fields.clone(), ..Default::default() };
    let sample = client.step(step).await?.into_inner().sample.ok_or("no sample")?;
    show(sample.step, sample.fields[0].value.as_ref().ok_or("no value")?, 0);

    let stream = pb::StreamRequest { session_id: session_id.clone(), to: 1000, every: 250, fields, ..Default::default() };
    let mut parts = client.stream(stream).await?.into_inner();
    while let Some(part) = parts.message().await? {
        for (k, step) in part.steps.iter().enumerate() {
            show(*step, part.fields[0].value.as_ref().ok_or("no value")?, k);
        }
        if let Some(status) = part.run_status {
            println!("{}", status.outcome().as_str_name());
        }
    }
    client.delete_session(pb::DeleteSessionRequest { session_id }).await?;
    Ok(())
}
